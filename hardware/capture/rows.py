"""The rows that a capture which broke off has left on disk."""

from __future__ import annotations

import csv
import io
import itertools
import math
from dataclasses import dataclass
from pathlib import Path

from armtwin.models.errors import RecordingError

_MAX_BYTES = 1 << 28


@dataclass(frozen=True)
class Row:
    """One row of a CSV file: its cells, and the bytes of the file up to its end."""

    cells: list[str]
    end: int


def whole_rows(samples: Path) -> list[Row]:
    """Return the rows of a CSV file, its header first, without a last one that was torn by a power cut.

    Raises `RecordingError` for a file that is no CSV.
    """
    if samples.stat().st_size > _MAX_BYTES:
        raise RecordingError(f"{samples}: larger than {_MAX_BYTES} bytes; choose another --out")
    content = samples.read_bytes()
    try:
        lines = list(io.StringIO(content[: content.rfind(b"\n") + 1].decode("utf-8")))
        ends = [0, *itertools.accumulate(len(line.encode("utf-8")) for line in lines)]
        reader = csv.reader(lines)
        return [Row(cells, ends[reader.line_num]) for cells in reader]
    except (UnicodeDecodeError, csv.Error) as error:
        raise RecordingError(f"{samples}: not a CSV file in UTF-8 ({error}); choose another --out") from None


def read_time_s(cell: str, where: str) -> float | None:
    """Return what a cell of column `time_s` says, None where it is empty; raises `RecordingError`, naming `where`."""
    if not cell:
        return None
    try:
        time_s = float(cell)
    except ValueError:
        time_s = math.nan
    if not math.isfinite(time_s):
        raise RecordingError(
            f"{where}: time_s is '{cell[:40]}', a finite number of seconds is wanted; mend it, or choose another --out"
        )
    return time_s


def line_of(cells: list[str]) -> bytes:
    """Return the line of a file that holds these cells."""
    out = io.StringIO()
    csv.writer(out, lineterminator="\n").writerow(cells)
    return out.getvalue().encode("utf-8")


def cells_of(line: bytes) -> list[str]:
    """Return the cells of one line: the inverse."""
    return next(csv.reader([line.decode("utf-8")]))
