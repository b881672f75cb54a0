"""One recording as spreadsheets, loggers and people save it: it reads the same, to the last bit."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from armtwin.models.errors import RecordingError
from armtwin.models.recordings.reader import read_recording

HEADER = {"schema": "armtwin.recording/1", "arm": {"name": "arm", "link_lengths_mm": [100.0]}}
ROWS = "\n".join(f"{k},,sweep,{0.17 * k:.3f},{0.19 * k:.3f}" for k in range(8)) + "\n"
COLUMNS = "sample,time_s,trajectory,theta1_cmd_rad,theta1_meas_rad\n"
PLAIN = COLUMNS + ROWS
DEGREES = COLUMNS.replace("_rad", "_deg") + "\n".join(f"{k},,sweep,{10 * k},{11 * k}" for k in range(8)) + "\n"


def read(folder: Path, data: bytes) -> tuple[np.ndarray, np.ndarray]:
    (folder / "recording.json").write_text(json.dumps(HEADER))
    (folder / "samples.csv").write_bytes(data)
    found = read_recording(folder)
    assert found.q_meas is not None
    return found.q_cmd[:, 0], found.q_meas[:, 0]


@pytest.mark.parametrize(
    "data",
    [
        ("# servo log of 2026-01-01\n" + PLAIN).encode(),
        ("sep=,\n" + PLAIN).encode(),
        PLAIN.replace(",", ";").replace(".", ",").encode(),
        PLAIN.replace(",", ";").encode(),
        PLAIN.replace(",", "\t").encode(),
        PLAIN.encode("utf-16"),
        PLAIN.replace("\n", "\r\n").encode("utf-8-sig"),
    ],
    ids=["comment", "sep", "semicolons and commas", "semicolons and points", "tabs", "UTF-16", "mark"],
)
def test_a_flavour_reads_as_the_plain_file_does(tmp_path: Path, data: bytes) -> None:
    commanded, measured = read(tmp_path, data)
    np.testing.assert_array_equal(commanded, [float(f"{0.17 * k:.3f}") for k in range(8)])
    np.testing.assert_array_equal(measured, [float(f"{0.19 * k:.3f}") for k in range(8)])


def test_degrees_are_read_as_such(tmp_path: Path) -> None:
    commanded, measured = read(tmp_path, DEGREES.encode())
    np.testing.assert_allclose(commanded, np.radians(10 * np.arange(8)))
    np.testing.assert_allclose(measured, np.radians(11 * np.arange(8)))


def test_degrees_in_a_column_of_radians_are_refused_with_both_remedies(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match=r"name the column theta1_meas_deg, or multiply by pi/180"):
        read(tmp_path, DEGREES.replace("_deg", "_rad").encode())


@pytest.mark.parametrize(
    ("cell", "said"),
    [
        ("12:30:05.5", "write seconds from the start"),
        ("2026-01-01 12:30", "write seconds from the start"),
        ("0.5 rad", "leave the unit out of the cells"),
        ("30°", "leave the unit out of the cells"),
        ("1 234.5", "leave out what separates thousands"),
        ("#N/A", "leave the cell empty"),
    ],
)
def test_a_cell_that_is_nearly_a_number_is_refused_with_what_to_do(tmp_path: Path, cell: str, said: str) -> None:
    with pytest.raises(RecordingError, match=said) as error:
        read(tmp_path, PLAIN.replace("3,,sweep", f"3,{cell},sweep").encode())
    assert f"line 5, column 'time_s': '{cell}' is no number" in str(error.value)
