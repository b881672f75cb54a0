from pathlib import Path

import pytest

from armtwin.hardware.capture.rows import cells_of, line_of, whole_rows
from armtwin.models.errors import RecordingError


@pytest.fixture
def samples(tmp_path: Path) -> Path:
    return tmp_path / "samples.csv"


def test_each_row_ends_where_the_next_begins_also_behind_a_cell_of_two_lines(samples: Path):
    lines = [line_of(cells) for cells in (["sample", "trajectory"], ["0", "überall,\nund oben"], ["1", "b"])]
    samples.write_bytes(b"".join(lines))

    rows = whole_rows(samples)

    assert [row.cells for row in rows] == [["sample", "trajectory"], ["0", "überall,\nund oben"], ["1", "b"]]
    assert [row.end for row in rows] == [len(b"".join(lines[: i + 1])) for i in range(3)]


def test_a_torn_last_row_is_left_out(samples: Path):
    samples.write_bytes(b"sample\n0\n1")

    assert [row.cells for row in whole_rows(samples)] == [["sample"], ["0"]]


def test_what_is_no_text_is_refused(samples: Path):
    samples.write_bytes(b"sample\n\xff\xfe\n")

    with pytest.raises(RecordingError, match=r"samples.csv: not a CSV file in UTF-8"):
        whole_rows(samples)


def test_cells_are_read_back_from_their_line():
    assert cells_of(line_of(["0", 'a "b", c', ""])) == ["0", 'a "b", c', ""]
