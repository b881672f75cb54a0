"""The validation trajectory as it was run, drawn as in Figures 5 and 6: any number of runs, each in its colour."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import plotly.graph_objects as go
from numpy.typing import NDArray

from armtwin.scenarios.report.style import COLOURS, figure

Array = NDArray[np.float64]
Runs = Mapping[str, Mapping[str, Any]]

# What the arm was commanded by, in the order of the story.
LABELS = {"before": "before calibration", "after": "after calibration", "extended": "with the extended twin"}
_COLOURS = {"before": COLOURS["drawing"], "after": COLOURS["geometry"], "extended": COLOURS["extended"]}


def line_path(commanded_mm: Any, runs: Runs) -> go.Figure:
    """Return the tip's measured path in the plane; lines join each pose to where it should be."""
    fig = figure("x, mm", "y, mm", height=470)
    goal = _array(commanded_mm)
    fig.add_scatter(
        x=goal[:, 0], y=goal[:, 1], mode="lines", name="commanded", line={"color": COLOURS["commanded"], "width": 4}
    )
    for name, run in runs.items():
        xy = _array(run["measured_mm"])
        gap = np.full_like(xy, np.nan)
        spokes = np.stack([goal, xy, gap], axis=1).reshape(-1, 2)
        fig.add_scatter(
            x=spokes[:, 0],
            y=spokes[:, 1],
            mode="lines",
            showlegend=False,
            hoverinfo="skip",
            line={"color": _COLOURS[name], "width": 0.7},
        )
        dots = {"color": _COLOURS[name], "size": 6}
        fig.add_scatter(x=xy[:, 0], y=xy[:, 1], mode="markers", name=LABELS[name], marker=dots)
    fig.update_yaxes(scaleanchor="x")
    return fig


def line_displacements(commanded_mm: Any, runs: Runs) -> list[go.Figure]:
    """Return x and y along the line, commanded and measured (Figure 5)."""
    series = [("commanded", COLOURS["commanded"], _array(commanded_mm))]
    series += [(LABELS[name], _COLOURS[name], _array(run["measured_mm"])) for name, run in runs.items()]
    figures = []
    for axis, letter in enumerate("xy"):
        fig = figure("pose", f"{letter}, mm", height=360)
        for name, colour, xy in series:
            fig.add_scatter(y=xy[:, axis], mode="lines", name=name, line={"color": colour, "width": 2})
        figures.append(fig)
    return figures


def line_error(runs: Runs, paper_mean_mm: Mapping[str, float], noise_floor_mm: float | None = None) -> go.Figure:
    """Return the tip's distance from where it should be (Figure 6), as measured and, thin, as it truly was.

    Dashed are the paper's means, mm by run. Where a noise floor is given, the mean that a perfect arm would be measured
    to have, mm, it is dotted, and the axis is logarithmic: between the floor and the paper lie powers of ten.
    """
    fig = figure("pose", "error, mm")
    first = next(iter(runs))
    for name, run in runs.items():
        line, dots = {"color": _COLOURS[name]}, {"size": 5}
        fig.add_scatter(y=run["error_mm"], mode="lines+markers", name=LABELS[name], line=line, marker=dots)
        thin = {"color": COLOURS["truth"], "width": 1}
        fig.add_scatter(y=run["true_error_mm"], mode="lines", name="true error", line=thin, showlegend=name == first)
        if name in paper_mean_mm:
            dashed = {"color": COLOURS["paper"], "dash": "dash"}
            _level(fig, run, paper_mean_mm[name], "the paper's means", dashed, showlegend=name == first)
    if noise_floor_mm is None:
        fig.update_yaxes(rangemode="tozero")
    else:
        dotted = {"color": COLOURS["commanded"], "dash": "dot"}
        _level(fig, runs[first], noise_floor_mm, "noise alone", dotted)
        fig.update_yaxes(type="log", dtick=1)
    return fig


def _level(fig: go.Figure, run: Mapping[str, Any], mm: float, name: str, line: dict[str, Any], **more: Any) -> None:
    """Draw a level along the whole run."""
    fig.add_scatter(x=[0, len(run["error_mm"]) - 1], y=[mm, mm], mode="lines", name=name, line=line, **more)


def _array(points: Any) -> Array:
    return np.array(points, dtype=float)
