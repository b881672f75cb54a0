"""Results that show themselves in a notebook, and give their columns to whatever makes tables of them.

`pandas.DataFrame(result.columns())` and `polars.DataFrame(result.columns())` take them as they are.
"""

from __future__ import annotations

import html
from collections.abc import Mapping
from typing import Any

# Rows that a notebook shows of a long table.
_SHOWN = 12


def html_table(title: str, columns: Mapping[str, Any]) -> str:
    """Return a heading and the first rows of sequences of one length; everything from outside is escaped."""
    rows = len(next(iter(columns.values()))) if columns else 0
    head = "".join(f"<th>{html.escape(name)}</th>" for name in columns)
    body = "".join(
        "<tr>" + "".join(f"<td>{html.escape(_cell(column[row]))}</td>" for column in columns.values()) + "</tr>"
        for row in range(min(rows, _SHOWN))
    )
    more = f"<p>… {rows} rows</p>" if rows > _SHOWN else ""
    return f"<p><b>{html.escape(title)}</b></p><table><tr>{head}</tr>{body}</table>{more}"


def _cell(value: Any) -> str:
    if value is None:
        return ""
    return f"{value:.6g}" if isinstance(value, float) else str(value)
