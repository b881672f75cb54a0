"""CSV files as people have them: read where their form cannot be mistaken, refused with the remedy where it can.

Taken: commas, semicolons or tabs between cells, a decimal comma, UTF-8 or UTF-16, a byte order mark, Excel's `sep=`
line, comment lines, blank lines, empty cells at the end of every line, and columns in another unit than the contract's
where their names say which (`theta1_cmd_deg`, `time_ms`). Messages count lines from the file's first one.
"""

from __future__ import annotations

import codecs
import csv
import math
import re
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from armtwin.models.errors import InputError, nearest, shown

# Names of the byte order marks; UTF-32's begins with UTF-16's, so it comes first.
_MARKS = (
    (codecs.BOM_UTF8, "utf-8-sig"),
    (codecs.BOM_UTF32_LE, "utf-32"),
    (codecs.BOM_UTF32_BE, "utf-32"),
    (codecs.BOM_UTF16_LE, "utf-16"),
    (codecs.BOM_UTF16_BE, "utf-16"),
)
_SEPARATORS = {",": "commas", ";": "semicolons", "\t": "tabs", "|": "bars"}
_COMMENTS = ("#", "%", "//")
_DECIMAL_COMMA = re.compile(r"[+-]?\d*,\d+([eE][+-]?\d+)?")
_DECIMAL_POINT = re.compile(r"[+-]?(\d+\.\d*|\.\d+)([eE][+-]?\d+)?")
_THOUSANDS = re.compile(r"[+-]?\d{1,3}([.,]\d{3})*[.,]\d+")
# What a column may be given in, by the end of its name: the contract's ending and the factor to it.
_UNITS = {"_deg": ("_rad", math.pi / 180.0), "_ms": ("_s", 1e-3), "_us": ("_s", 1e-6), "_g": ("_kg", 1e-3)}
# First bytes of what people save or download in a table's place, in small letters, and what each is.
_NO_TABLES = {
    b"pk\x03\x04": "a workbook of a spreadsheet program",
    b"\xd0\xcf\x11\xe0": "a workbook of a spreadsheet program",
    b"<!doctype html": "a web page",
    b"<html": "a web page",
    b"%pdf": "a PDF",
    b"{": "JSON",
}
# Spreadsheets and people write the true minus.
_MINUS = str.maketrans({"\u2212": "-"})


@dataclass(frozen=True, eq=False)
class CsvTable:
    """The cells of a CSV file.

    Attributes:
        name: of the file, for messages.
        columns: names as the contract has them.
        rows: cells as text, as many in a row as there are columns.
        lines: number of each row's line in the file, from 1.
        decimal: the sign before decimals.
        given: columns that the file has under another name and unit: that name, and the factor to the contract's unit.

    """

    name: str
    columns: list[str]
    rows: list[list[str]]
    lines: list[int]
    decimal: str = "."
    given: dict[str, tuple[str, float]] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.rows)

    def text(self, row: int, column: str) -> str:
        """Return a cell as it stands."""
        return self.rows[row][self.columns.index(column)]

    def number(self, row: int, column: str) -> float:
        """Return a cell's number in the contract's unit; raises ValueError where it is none."""
        text = self.text(row, column).strip().translate(_MINUS)
        value = float(text.replace(",", ".") if self.decimal == "," else text)
        return value * self.given[column][1] if column in self.given else value

    def at(self, row: int, column: str) -> str:
        """Return where a cell stands, for a message."""
        return f"{self.name}: line {self.lines[row]}, column '{self.given.get(column, (column,))[0]}'"


def read_csv(path: Path, most_bytes: int, what: str) -> CsvTable:
    """Read a CSV file; `what` says what it is to hold ("a row a pose").

    Raises `InputError` where it is too large, no text, has no row, or its form can be read in two ways; and OSError.
    """
    if path.stat().st_size > most_bytes:
        raise InputError(f"{path.name}: larger than {most_bytes} bytes")
    text = _decoded(path)
    numbered = [(number, line) for number, line in enumerate(text.splitlines(), start=1) if _holds_cells(line)]
    separator, numbered = _separator(path.name, numbered)
    cells = [(number, line) for number, line in _cells(path.name, numbered, separator) if any(c.strip() for c in line)]
    if len(cells) < 2:
        raise InputError(f"{path.name}: no rows; {what} is wanted under the line of column names")
    names = [name.strip() for name in cells[0][1]]
    lines, rows = [number for number, _ in cells[1:]], [line for _, line in cells[1:]]
    while names and not names[-1] and all(not row[len(names) - 1 :] or not any(row[len(names) - 1 :]) for row in rows):
        names.pop()
        rows = [row[: len(names)] for row in rows]
    for number, row in zip(lines, rows, strict=True):
        if len(row) != len(names):
            hint = _comma_hint(names, row) if separator == "," else ""
            raise InputError(f"{path.name}: line {number} has {len(row)} cells, the header has {len(names)}{hint}")
    decimal = _decimal(path.name, names, lines, rows)
    return CsvTable(path.name, names, rows, lines, decimal)


def in_units(table: CsvTable, valid: list[str]) -> CsvTable:
    """Return the table with the names of `valid` columns, whose ending is their unit.

    Raises `InputError` for a column that is none of them, that stands twice, or whose name says no unit.
    """
    columns, given = [], {}
    for name in table.columns:
        wanted, factor = _contract_name(name, valid)
        if wanted not in valid:
            _refuse_unit(table.name, name, valid)
            raise InputError(f"{table.name}: unknown column '{shown(name)}'{nearest(name, valid)}")
        if wanted in columns:
            raise InputError(f"{table.name}: column '{wanted}' stands twice; keep one")
        columns.append(wanted)
        if name != wanted:
            given[wanted] = (name, factor)
    return CsvTable(table.name, columns, table.rows, table.lines, table.decimal, given)


def _contract_name(name: str, valid: list[str]) -> tuple[str, float]:
    if name not in valid:
        name = _plain(name, valid)
        for ending, (wanted, factor) in _UNITS.items():
            if name.endswith(ending) and name.removesuffix(ending) + wanted in valid:
                return name.removesuffix(ending) + wanted, factor
    return name, 1.0


def _plain(name: str, valid: list[str]) -> str:
    """Return 'Theta1 cmd [deg]', as people write headings, as theta1_cmd_deg where that is one of ours."""
    if not re.search(r"[\s()\[\]°]", name):
        return name
    words = "_".join(re.findall(r"[A-Za-z0-9]+", name.replace("°", " deg ")))
    known = list(valid)
    for ending, (wanted, _) in _UNITS.items():
        known += [one.removesuffix(wanted) + ending for one in valid if one.endswith(wanted)]
    return {one.lower(): one for one in known}.get(words.lower(), name)


def _refuse_unit(file: str, name: str, valid: list[str]) -> None:
    """Ask for the unit of a column whose name is one of ours but for it."""
    ours = [wanted for wanted in valid if wanted.rsplit("_", 1)[0] == name]
    if ours:
        others = [ending for ending, (wanted, _) in _UNITS.items() if ours[0].endswith(wanted)]
        names = [ours[0], *(f"{name}{ending}" for ending in others)]
        raise InputError(f"{file}: column '{name}' says no unit; name it {' or '.join(names)}")


def _decoded(path: Path) -> str:
    data = path.read_bytes()
    start = data.lstrip()[:20].lower()
    for mark, what in _NO_TABLES.items():
        if start.startswith(mark):
            raise InputError(f"{path.name}: is {what}, no CSV file; save it as 'CSV UTF-8'")
    encoding = next((name for mark, name in _MARKS if data.startswith(mark)), None) or _unmarked(data)
    try:
        text = data.decode(encoding)
    except UnicodeDecodeError as error:
        remedy = "save it as 'CSV UTF-8'"
        raise InputError(f"{path.name}: not a CSV file in UTF-8 or UTF-16 ({error.reason}); {remedy}") from None
    if "\0" in text:
        raise InputError(f"{path.name}: holds zero bytes, no CSV file; save it as 'CSV UTF-8'")
    return text


def _unmarked(data: bytes) -> str:
    """Tell UTF-16 without a mark by the zeros that every second byte of plain letters is."""
    head = data[:400]
    pairs = len(head) // 2
    if pairs and head[1::2].count(0) > 0.7 * pairs:
        return "utf-16-le"
    if pairs and head[0::2].count(0) > 0.7 * pairs:
        return "utf-16-be"
    return "utf-8"


def _holds_cells(line: str) -> bool:
    return bool(line.strip()) and not line.lstrip().startswith(_COMMENTS)


def _separator(file: str, numbered: list[tuple[int, str]]) -> tuple[str, list[tuple[int, str]]]:
    """Return what stands between cells, and the lines without Excel's `sep=` line."""
    if not numbered:
        return ",", numbered
    first = numbered[0][1].strip().strip('"')
    if first.lower().startswith("sep=") and len(first) == 5:
        if first[4] not in _SEPARATORS:
            raise InputError(f"{file}: line 1 says '{first}'; {', '.join(_SEPARATORS.values())} can be read")
        return first[4], numbered[1:]
    if first.lower() == "sep=":  # a tab that strip() took
        return "\t", numbered[1:]
    header = numbered[0][1]
    counts = {separator: header.count(separator) for separator in _SEPARATORS}
    best = max(counts, key=lambda separator: counts[separator])
    if not counts[best] and len(header.split()) > 2:
        raise InputError(
            f"{file}: line {numbered[0][0]} has words with spaces between; save it with commas between cells"
        )
    return best if counts[best] else ",", numbered


def _cells(file: str, numbered: list[tuple[int, str]], separator: str) -> list[tuple[int, list[str]]]:
    try:
        return [(number, next(csv.reader([line], delimiter=separator, strict=True))) for number, line in numbered]
    except csv.Error as error:
        raise InputError(f"{file}: not a CSV file ({error})") from None


def _decimal(file: str, names: list[str], lines: list[int], rows: list[list[str]]) -> str:
    """Return the sign before decimals; refuse a table that uses both, or separates thousands."""
    comma = point = None
    for number, row in zip(lines, rows, strict=True):
        for name, cell in zip(names, row, strict=True):
            text = cell.strip()
            if name == "trajectory" or not text:
                continue
            if "," in text and "." in text and _THOUSANDS.fullmatch(text):
                raise InputError(
                    f"{file}: line {number}, column '{name}': '{text[:40]}' has signs between thousands; leave them out"
                )
            if comma is None and _DECIMAL_COMMA.fullmatch(text):
                comma = (number, text)
            elif point is None and _DECIMAL_POINT.fullmatch(text):
                point = (number, text)
        if comma and point:
            raise InputError(
                f"{file}: decimal comma in line {comma[0]} ('{comma[1][:40]}') and decimal point in line {point[0]} "
                f"('{point[1][:40]}'); use one of them"
            )
    return "," if comma else "."


def _comma_hint(names: list[str], row: list[str]) -> str:
    """Say what it is where every number of a line was cut in two by its decimal comma."""
    return "; if these are decimal commas, save it with semicolons between cells" if len(row) > len(names) else ""


def remedy(text: str) -> str:
    """Return what to do about a cell that is meant as a number and is none, as the end of a sentence, or nothing."""
    text = text.strip()
    if re.fullmatch(r"(\d+:)+\d+([.,]\d+)?", text) or re.match(r"\d{4}-\d\d-\d\d", text):
        return "; write seconds from the start, not the time of day"
    if re.fullmatch(r"[+-]?[\d.,]+\s*[^\d\s.,:]{1,8}", text):
        return "; leave the unit out of the cells, the column's name says it"
    if re.fullmatch(r"[+-]?\d{1,3}([\s'’]\d{3})+([.,]\d+)?", text):
        return "; leave out what separates thousands"
    if text.lower() in ("rad", "deg", "°", "mm", "px", "s", "ms", "[rad]", "[deg]", "[px]", "[s]"):
        return "; leave out the row of units, the columns' names say them"
    if text.lower() in ("na", "n/a", "#n/a", "null", "none", "-", "--"):
        return "; leave the cell empty where nothing was measured"
    return ""


def finite(table: CsvTable, row: int, column: str) -> float:
    """Return a cell's number; raises `InputError` where it is none or not finite."""
    try:
        value = table.number(row, column)
    except ValueError:
        value = math.nan
    if not np.isfinite(value):
        text = table.text(row, column)
        raise InputError(f"{table.at(row, column)}: '{text[:40]}' is no finite number{remedy(text)}")
    return value
