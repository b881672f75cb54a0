"""One colour for one thing, wherever it is shown, and the look of every figure."""

from __future__ import annotations

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


def figure(x_title: str, y_title: str, height: int = 380, **layout: Any) -> go.Figure:
    """Return an empty figure with axes named, units in their titles."""
    fig = go.Figure()
    fig.update_layout(
        template="plotly_white",
        height=height,
        margin={"l": 60, "r": 20, "t": 30, "b": 50},
        font={"family": "system-ui, sans-serif", "size": 13},
        legend={"orientation": "h", "y": 1.02, "yanchor": "bottom", "x": 0},
        hovermode="closest",
        **layout,
    )
    fig.update_xaxes(title=x_title, zeroline=False, showline=True, linecolor="#999", ticks="outside")
    fig.update_yaxes(title=y_title, zeroline=False, showline=True, linecolor="#999", ticks="outside")
    return fig
