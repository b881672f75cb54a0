"""Tables for spreadsheets, whose cells no spreadsheet takes for formulas: a student chooses his name."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from typing import Any

_FORMULAS = tuple("=+-@\t\r\n")


def spreadsheet(rows: Sequence[Sequence[Any]]) -> str:
    """Return rows as CSV; text that begins like a formula has an apostrophe before it."""
    out = io.StringIO()
    guarded = [
        [f"'{cell}" if isinstance(cell, str) and cell.startswith(_FORMULAS) else cell for cell in row] for row in rows
    ]
    csv.writer(out, lineterminator="\n").writerows(guarded)
    return out.getvalue()
