"""What the arm is commanded to do (Figure 4)."""

from __future__ import annotations

from typing import Any

import numpy as np
import plotly.graph_objects as go

from armtwin.scenarios.report.data import RunData
from armtwin.scenarios.report.section import Section, plot, plots
from armtwin.scenarios.report.style import figure
from armtwin.scenarios.runner.paper_checks import printed_equation_8_error_mm

_TRAJECTORIES = ["#0072b2", "#cc79a7", "#8a8a8a", "#e69f00", "#56b4e9"]
_JOINTS = ["#0072b2", "#d55e00", "#009e73"]


def trajectory_section(run: RunData) -> Section:
    """Show the paths in the plane and the joint angles that the drawn arm needs for them."""
    paths = run.results["figures"]["4"]
    return Section(
        slug="trajectories",
        title="What the arm is told to do (Figure 4)",
        lead=(
            "The drawing's inverse kinematics turns each path of the tip into servo angles. Equation (8) is used with "
            f"its sign corrected: as printed it misses the paper's own circles by up to "
            f"{printed_equation_8_error_mm():.0f} mm."
        ),
        blocks=(
            plot(
                _paths(paths), "Commanded paths of the tip F in the robot frame, origin at marker A. Arrows: direction."
            ),
            plots(_joints(paths), "Commanded joint angles, pose by pose, in the order of the run."),
        ),
    )


def _paths(paths: dict[str, Any]) -> go.Figure:
    fig = figure("x, mm", "y, mm", height=430)
    for colour, (name, path) in zip(_TRAJECTORIES * len(paths), paths.items(), strict=False):
        xy = np.array(path["poses_mm_rad"])[:, :2]
        fig.add_scatter(
            x=xy[:, 0],
            y=xy[:, 1],
            mode="lines+markers",
            name=name,
            marker={"symbol": "arrow", "angleref": "previous", "size": 8},
            line={"color": colour, "width": 1},
        )
    fig.update_yaxes(scaleanchor="x")
    return fig


def _joints(paths: dict[str, Any]) -> list[go.Figure]:
    figures = []
    for name, path in paths.items():
        fig = figure("pose", "angle, degrees", height=340, title=name)
        q = np.degrees(np.array(path["q_cmd_rad"]))
        for joint, colour in zip(range(q.shape[1]), _JOINTS, strict=False):
            fig.add_scatter(y=q[:, joint], mode="lines", line={"color": colour}, name=f"θ{joint + 1}")
        fig.update_layout(legend={"y": -0.25, "yanchor": "top"})
        figures.append(fig)
    return figures
