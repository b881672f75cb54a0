"""The labs' pictures: arrows of residuals, curves, and photographs."""

from __future__ import annotations

from collections.abc import Mapping

import cv2
import marimo as mo
import numpy as np
import plotly.graph_objects as go
from numpy.typing import NDArray

from armtwin.models.errors import JobError
from armtwin.scenarios.report.style import COLOURS, figure

Array = NDArray[np.float64]


class Picture(go.Figure):  # type: ignore[misc]  # plotly is untyped
    """A figure that a notebook shows with the plotly that is installed.

    marimo's own way of showing a plotly figure asks a server on the network for MathJax, and a lab asks for nothing.
    """

    def _display_(self) -> mo.Html:
        options = {"displayModeBar": False, "responsive": True}
        drawn = self.to_html(full_html=False, include_plotlyjs=True, config=options)
        # A standard page without margins: in any other the frame grows again and again.
        return mo.iframe(f"<!doctype html><body style='margin:0'>{drawn}", height=f"{self.layout.height}px")


def arrows(at_mm: Array, miss_mm: Array, enlarged: float, title: str = "") -> Picture:
    """Draw (N, 2) misses, `enlarged` times, where they were seen."""
    fig = Picture(figure("x, mm", "y, mm", height=420, title=title or f"arrows enlarged {enlarged:g} times"))
    ends = at_mm + enlarged * miss_mm
    gap = np.full(len(at_mm), np.nan)
    x, y = (np.stack([at_mm[:, k], ends[:, k], gap], axis=-1).ravel() for k in (0, 1))
    fig.add_scatter(x=x, y=y, mode="lines", line={"width": 1.3, "color": COLOURS["geometry"]}, hoverinfo="skip")
    fig.add_scatter(x=at_mm[:, 0], y=at_mm[:, 1], mode="markers", marker={"size": 4, "color": COLOURS["truth"]})
    fig.update_yaxes(scaleanchor="x")
    fig.update_layout(showlegend=False)
    return fig


def curves(
    x: Array, by_name: Mapping[str, Array], x_title: str, y_title: str, *, log: bool = False, marks: bool = False
) -> Picture:
    """Draw named curves over a common x."""
    fig = Picture(figure(x_title, y_title))
    palette = list(COLOURS.values())
    for number, (name, y) in enumerate(by_name.items()):
        mode = "markers" if marks else "lines"
        fig.add_scatter(x=x, y=y, mode=mode, name=name, line={"color": palette[(4 + number) % len(palette)]})
    if log:
        fig.update_yaxes(type="log")
    return fig


def photograph(image: NDArray[np.uint8], width_px: int = 760) -> bytes:
    """Return a picture (H, W, 3) BGR or (H, W) as PNG, no wider than `width_px`, for `mo.image`."""
    height, width = image.shape[:2]
    if width > width_px:
        image = np.asarray(
            cv2.resize(image, (width_px, round(height * width_px / width)), interpolation=cv2.INTER_AREA)
        )
    done, data = cv2.imencode(".png", image)
    if not done:
        raise JobError("the picture cannot be encoded")
    return data.tobytes()
