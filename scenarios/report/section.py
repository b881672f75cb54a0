"""A section of a report: a heading, and blocks of prose, tables, figures and pictures in their order."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from dataclasses import dataclass, field

import cv2
import numpy as np
import plotly.graph_objects as go
from markupsafe import Markup
from numpy.typing import NDArray

from armtwin.scenarios.report.templates import render

Cell = str | float | int | None


@dataclass(frozen=True)
class Section:
    """One chapter of a report.

    Attributes:
        slug: its address within the page.
        title: says what is seen.
        lead: the answer in a sentence or two.
        blocks: HTML of what follows, each made by a function of this module.

    """

    slug: str
    title: str
    lead: str
    blocks: tuple[Markup, ...] = field(default=())


def prose(text: str) -> Markup:
    """Return a paragraph; the text is escaped."""
    return render("prose.html", text=text)


def table(header: Sequence[str], rows: Sequence[Sequence[Cell]], caption: str, marked: Sequence[int] = ()) -> Markup:
    """Return a table; columns whose number stands in `marked` are armtwin's own answer and are set off."""
    cells = [[_text(cell) for cell in row] for row in rows]
    return render("table.html", header=header, rows=cells, caption=caption, marked=set(marked))


def plot(figure: go.Figure, caption: str) -> Markup:
    """Return an interactive figure; the page brings plotly.js once."""
    return render("figure.html", inner=_plotly(figure), caption=caption)


def plots(figures: Sequence[go.Figure], caption: str) -> Markup:
    """Return figures that belong together: side by side where the page is wide, one below the other on a phone."""
    return render("plots.html", figures=[_plotly(figure) for figure in figures], caption=caption)


def picture(image: NDArray[np.uint8], caption: str, quality: int = 88) -> Markup:
    """Return a picture (H, W, 3) BGR or (H, W) grey, as JPEG within the page."""
    return render("pictures.html", columns=1, pictures=[(_jpeg(image, quality), "")], caption=caption)


def gallery(
    images: Sequence[tuple[str, NDArray[np.uint8]]], caption: str, columns: int = 3, quality: int = 85
) -> Markup:
    """Return named pictures side by side."""
    return render(
        "pictures.html",
        columns=columns,
        pictures=[(_jpeg(image, quality), name) for name, image in images],
        caption=caption,
    )


def fold(summary: str, blocks: Sequence[Markup]) -> Markup:
    """Return blocks that open on a click."""
    return render("fold.html", summary=summary, blocks=blocks)


def number(value: float | None, digits: int = 4, unit: str = "") -> str:
    """Write a number with fixed decimals; a dash for what is not there."""
    if value is None or not np.isfinite(value):
        return "–"
    text = f"{value:.{digits}f}".replace("-", "−")
    return f"{text} {unit}".rstrip()


def with_std(value: float | None, std: float | None, digits: int = 4) -> str:
    """Write value ± standard deviation."""
    if std is None or value is None or not np.isfinite(std):
        return number(value, digits)
    return f"{number(value, digits)} ± {number(std, digits)}"


def _plotly(figure: go.Figure) -> Markup:
    inner = figure.to_html(
        full_html=False, include_plotlyjs=False, config={"displayModeBar": False, "responsive": True}
    )
    return Markup(inner)  # noqa: S704  # plotly escapes its data


def _text(cell: Cell) -> str:
    if cell is None:
        return "–"
    return cell if isinstance(cell, str) else number(float(cell))


def _jpeg(image: NDArray[np.uint8], quality: int) -> str:
    data = cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, quality])[1]
    return base64.b64encode(data.tobytes()).decode("ascii")
