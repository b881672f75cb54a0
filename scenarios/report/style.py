"""One colour for one thing, wherever it is shown, and the look of every figure."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from typing import Any

import plotly.graph_objects as go

# Okabe and Ito's palette, which the colour-blind can tell apart.
COLOURS = {
    "truth": "#222222",
    "commanded": "#8a8a8a",
    "paper": "#e69f00",  # what the paper printed
    "paper method": "#cc79a7",  # the paper's method, run on our bench
    "armtwin": "#0072b2",  # armtwin's own method
    # By which twin the arm is commanded or predicted: the drawing's, the calibrated geometry's, the extended one.
    "drawing": "#56b4e9",
    "geometry": "#d55e00",
    "extended": "#009e73",
}


# A phone's figure is about 270 px wide between its margins; a letter of an axis title takes about 6.5 px.
_TITLE_LETTERS = 40


def figure(x_title: str, y_title: str, height: int = 380, title: str | None = None, **layout: Any) -> go.Figure:
    """Return an empty figure with axes named, units in their titles; `title` says which of several it is."""
    fig = go.Figure()
    if title is not None:
        layout["title"] = {"text": _lines(title), "font": {"size": 14}, "x": 0.5, "xanchor": "center"}
    fig.update_layout(
        template="plotly_white",
        height=height,
        margin={"l": 60, "r": 20, "t": 30 if title is None else 50, "b": 50},
        font={"family": "system-ui, sans-serif", "size": 13},
        legend={"orientation": "h", "y": 1.02, "yanchor": "bottom", "x": 0},
        hovermode="closest",
        **layout,
    )
    fig.update_xaxes(title=_lines(x_title), zeroline=False, showline=True, linecolor="#999", ticks="outside")
    fig.update_yaxes(title=_lines(y_title), zeroline=False, showline=True, linecolor="#999", ticks="outside")
    return fig


def add_band(
    fig: go.Figure,
    x: Sequence[float],
    low: Sequence[float],
    high: Sequence[float],
    colour: str,
    opacity: float = 0.18,
) -> None:
    """Fill what lies between two curves over `x` in a colour, faintly and without a name."""
    fig.add_scatter(
        x=[*x, *reversed(x)],
        y=[*high, *reversed(low)],
        fill="toself",
        fillcolor=colour,
        opacity=opacity,
        line={"width": 0},
        hoverinfo="skip",
        showlegend=False,
    )


def _lines(title: str) -> str:
    """Break a title into lines that fit a phone; plotly cuts off what is longer."""
    return "<br>".join(textwrap.wrap(title, _TITLE_LETTERS))
