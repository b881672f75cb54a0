"""The validation line before and after (Figures 5 and 6)."""

from __future__ import annotations

from typing import Any

import numpy as np
import plotly.graph_objects as go
from plotly.subplots import make_subplots

from scenarios.report.data import RunData
from scenarios.report.section import Section, number, plot, table
from scenarios.report.style import COLOURS, figure

_LABELS = {"before": "before calibration", "after": "after calibration"}


def validation_section(run: RunData) -> Section:
    """Show path, displacements and error of the validation trajectory before and after."""
    found = run.results["figures"]["5_and_6"]
    paper = run.results["validation"]["paper"]
    rows = [
        [
            label,
            number(paper[f"mean_{name}_mm"], 4),
            number(found["runs"][name]["mean_mm"], 4),
            number(found["runs"][name]["true_mean_mm"], 4),
            number(found["runs"][name]["max_mm"], 3),
            number(found["runs"][name]["vision_error_mm"], 4),
        ]
        for name, label in _LABELS.items()
    ]
    rows.append(["reduction, %", number(paper["reduction_percent"], 1), number(found["reduction_percent"], 1)])
    return Section(
        slug="validation",
        title="The line, before and after (Figures 5 and 6)",
        lead=(
            f"Commanded again through the calibrated inverse kinematics, the tip's mean error on a line that no "
            f"calibration has seen falls from {found['mean_before_mm']:.2f} to {found['mean_after_mm']:.2f} mm, by "
            f"{found['reduction_percent']:.1f} %."
        ),
        blocks=(
            plot(_path(found), "The tip's path as the camera measured it. Lines join each pose to where it should be."),
            plot(_displacements(found), "Figure 5: x and y along the line, commanded and measured."),
            plot(
                _error(found, paper),
                "Figure 6: distance of the tip from the commanded path (equation 19). Dashed: the "
                "paper's means. Thin: what the error truly was, which only a simulated bench can tell.",
            ),
            table(
                ["", "paper, mean mm", "here, mean mm", "true mean, mm", "largest, mm", "camera's own error, rms mm"],
                [row + ["–"] * (6 - len(row)) for row in rows],
                "The camera's own error is the distance of the measured from the true tip.",
                marked=[2],
            ),
        ),
    )


def _path(found: dict[str, Any]) -> go.Figure:
    fig = figure("x, mm", "y, mm", height=470)
    goal = np.array(found["commanded_mm"])
    fig.add_scatter(
        x=goal[:, 0], y=goal[:, 1], mode="lines", name="commanded", line={"color": COLOURS["commanded"], "width": 4}
    )
    for name, label in _LABELS.items():
        xy = _array(found["runs"][name]["measured_mm"])
        gap = np.full_like(xy, np.nan)
        spokes = np.stack([goal, xy, gap], axis=1).reshape(-1, 2)
        fig.add_scatter(
            x=spokes[:, 0],
            y=spokes[:, 1],
            mode="lines",
            showlegend=False,
            hoverinfo="skip",
            line={"color": COLOURS[name], "width": 0.7},
        )
        fig.add_scatter(x=xy[:, 0], y=xy[:, 1], mode="markers", name=label, marker={"color": COLOURS[name], "size": 6})
    fig.update_yaxes(scaleanchor="x")
    return fig


def _displacements(found: dict[str, Any]) -> go.Figure:
    fig = make_subplots(rows=1, cols=2, subplot_titles=["along x", "along y"])
    goal = np.array(found["commanded_mm"])
    series = [("commanded", COLOURS["commanded"], goal)]
    series += [(label, COLOURS[name], _array(found["runs"][name]["measured_mm"])) for name, label in _LABELS.items()]
    for axis in range(2):
        for name, colour, xy in series:
            fig.add_scatter(
                y=xy[:, axis],
                row=1,
                col=axis + 1,
                mode="lines",
                name=name,
                legendgroup=name,
                line={"color": colour, "width": 2},
                showlegend=axis == 0,
            )
        fig.update_yaxes(title=f"{'xy'[axis]}, mm", col=axis + 1)
    fig.update_xaxes(title="pose")
    fig.update_layout(
        template="plotly_white",
        height=360,
        margin={"l": 60, "r": 20, "t": 40, "b": 50},
        legend={"orientation": "h", "y": 1.1, "yanchor": "bottom"},
    )
    return fig


def _error(found: dict[str, Any], paper: dict[str, float]) -> go.Figure:
    fig = figure("pose", "error, mm")
    for name, label in _LABELS.items():
        run = found["runs"][name]
        fig.add_scatter(
            y=run["error_mm"],
            mode="lines+markers",
            name=f"{label}, measured",
            line={"color": COLOURS[name]},
            marker={"size": 5},
        )
        fig.add_scatter(
            y=run["true_error_mm"], mode="lines", name=f"{label}, true", line={"color": COLOURS["truth"], "width": 1}
        )
        fig.add_hline(
            y=paper[f"mean_{name}_mm"],
            line={"color": COLOURS["paper"], "dash": "dash"},
            annotation_text=f"paper's mean {label}",
            annotation_position="bottom right",
        )
    fig.update_yaxes(rangemode="tozero")
    return fig


def _array(points: list[list[float | None]]) -> np.ndarray[Any, np.dtype[np.float64]]:
    return np.array(points, dtype=float)
