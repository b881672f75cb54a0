"""Tables as spreadsheets, loggers and people write them."""

from __future__ import annotations

import math
import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from armtwin.models.csv_table import in_units, read_csv
from armtwin.models.errors import InputError
from armtwin.models.plan import read_plan

COLUMNS = ["sample", "trajectory", "theta1_cmd_rad"]
PLAIN = "sample,trajectory,theta1_cmd_rad\n0,up,0.5\n1,up,-1.25\n"


def numbers(path: Path, data: bytes, column: str = "theta1_cmd_rad") -> list[float]:
    path.write_bytes(data)
    table = in_units(read_csv(path, 1 << 20, "one row a pose"), COLUMNS)
    return [table.number(row, column) for row in range(len(table))]


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "samples.csv"


@pytest.mark.parametrize(
    "text",
    [
        PLAIN,
        PLAIN.replace(",", ";"),
        PLAIN.replace(",", "\t"),
        PLAIN.replace(",", ";").replace(".", ","),
        PLAIN.replace(",", "\t").replace(".", ","),
        PLAIN.replace("0.5", '"0,5"').replace("-1.25", '"-1,25"'),
        "sep=,\n" + PLAIN,
        "sep=;\r\n" + PLAIN.replace(",", ";").replace("\n", "\r\n"),
        "# made by a logger, v1.2; comma, semicolon\n" + PLAIN + "# end\n",
        PLAIN.replace("\n", "\r"),
        PLAIN.replace("\n", ",\n"),
        PLAIN + ",,\n,,\n",
        PLAIN.replace("-1.25", "\u22121.25"),
        PLAIN.replace("theta1_cmd_rad", " theta1_cmd_rad "),
        PLAIN.replace(",", "|"),
        PLAIN.replace("theta1_cmd_rad", "Theta1_cmd [rad]"),
        PLAIN.replace("theta1_cmd_rad", "theta1 cmd (rad)"),
    ],
    ids=[
        *(
            "plain",
            "semicolons",
            "tabs",
            "decimal commas",
            "tabs and decimal commas",
            "quoted decimal commas",
            "sep",
            "sep;",
        ),
        *("comments", "old Mac", "a comma at every end", "empty rows below", "true minus", "spaces"),
        *("bars", "brackets", "words"),
    ],
)
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-32"])
def test_a_table_means_the_same_in_every_form(path: Path, text: str, encoding: str) -> None:
    if encoding == "utf-16-le" and "\u2212" in text:
        encoding = "utf-16"
    assert numbers(path, text.encode(encoding)) == [0.5, -1.25]


def test_a_column_in_degrees_is_turned_into_radians_and_named_as_it_stands(path: Path) -> None:
    degrees = PLAIN.replace("_rad", "_deg").replace("0.5", "90").replace("-1.25", "x")
    path.write_text(degrees)
    table = in_units(read_csv(path, 1 << 20, "one row a pose"), COLUMNS)
    assert table.number(0, "theta1_cmd_rad") == pytest.approx(math.pi / 2)
    assert table.at(1, "theta1_cmd_rad") == "samples.csv: line 3, column 'theta1_cmd_deg'"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (PLAIN.replace("theta1_cmd_rad", "theta1_cmd"), "says no unit; name it theta1_cmd_rad or theta1_cmd_deg"),
        (
            PLAIN.replace(".", ","),
            "line 2 has 4 cells, the header has 3; if these are decimal commas, save",
        ),
        (PLAIN.replace(",", ";").replace("0.5", "0,5"), "decimal comma in line 2 .* decimal point in line 3"),
        (PLAIN.replace(",", ";").replace("0.5", "1.234,5"), "'1.234,5' has signs between thousands"),
        (PLAIN.replace(",", " "), "words with spaces between; save it with commas"),
        ("sep=/\n" + PLAIN, "commas, semicolons, tabs, bars can be read"),
        (PLAIN.replace("sample", "theta1_cmd_deg"), "stands twice"),
        ("# only a comment\n", "no rows; one row a pose is wanted"),
    ],
)
def test_what_can_be_read_in_two_ways_is_refused_with_the_remedy(path: Path, text: str, said: str) -> None:
    with pytest.raises(InputError, match=said) as error:
        numbers(path, text.encode())
    assert str(error.value).startswith("samples.csv: ")


@pytest.mark.parametrize("data", [b"sample\xe9\xff\n0\n", b"a,b\n\x00\x00,1\n"], ids=["no UTF-8", "zero bytes"])
def test_what_is_no_text_is_refused_with_the_remedy(path: Path, data: bytes) -> None:
    with pytest.raises(InputError, match="save it as 'CSV UTF-8'"):
        numbers(path, data)


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (b"PK\x03\x04\x14\x00", "a workbook of a spreadsheet program"),
        (b"\n<!DOCTYPE html><html></html>", "a web page"),
        (b"%PDF-1.7", "a PDF"),
        (b'{"theta1": [0]}', "JSON"),
    ],
)
def test_what_is_no_table_is_named(path: Path, data: bytes, said: str) -> None:
    with pytest.raises(InputError, match=f"samples.csv: is {said}, no CSV file"):
        numbers(path, data)


def test_a_row_of_units_is_to_be_left_out(tmp_path: Path) -> None:
    path = tmp_path / "plan.csv"
    path.write_text("theta1_cmd_rad,theta2_cmd_rad\nrad,rad\n0.1,0.2\n")
    with pytest.raises(InputError, match="leave out the row of units"):
        read_plan(path, 2)


@given(st.lists(st.floats(-6, 6), min_size=1, max_size=5), st.sampled_from([";", "\t"]))
def test_any_number_survives_a_spreadsheet_with_decimal_commas(values: list[float], separator: str) -> None:
    rows = "".join(f"{k}{separator}t{separator}{repr(v).replace('.', ',')}\n" for k, v in enumerate(values))
    with tempfile.TemporaryDirectory() as folder:
        read = numbers(Path(folder) / "samples.csv", (separator.join(COLUMNS) + "\n" + rows).encode("utf-16"))
    np.testing.assert_array_equal(read, values)


def test_a_plan_without_trajectories_is_one_named_after_its_file(tmp_path: Path) -> None:
    path = tmp_path / "sweep.csv"
    path.write_text("theta1_cmd_deg;theta2_cmd_deg\n10,5;-20\n11;-21\n")
    plan = read_plan(path, 2)
    assert list(plan.trajectory) == ["sweep", "sweep"]
    np.testing.assert_allclose(np.degrees(plan.q_cmd), [[10.5, -20], [11, -21]])
