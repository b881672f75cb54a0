"""The arm's calibrations beside Table 4, and what of them can be known."""

from __future__ import annotations

from typing import Any

import numpy as np
import plotly.graph_objects as go

from scenarios.report.data import RunData
from scenarios.report.section import Section, number, plot, prose, table
from scenarios.report.style import COLOURS, figure

_SYMBOLS = {
    "delta_l1_mm": "Δl1, mm",
    "delta_l2_mm": "Δl2, mm",
    "delta_l4_mm": "Δl4, mm",
    "delta_l5_mm": "Δl5, mm",
    "delta_theta1_rad": "Δθ1, °",
    "delta_theta2_rad": "Δθ2, °",
    "delta_theta3_rad": "Δθ3, °",
}
_METHODS = {
    "least-squares": ("least squares", COLOURS["armtwin"]),
    "algorithm-1": ("Algorithm 1", COLOURS["paper method"]),
}


def calibration_section(run: RunData) -> Section:
    """Show Table 4 by both methods, each estimate's distance from the truth, and the singular values."""
    found = run.results["tables"]["4"]
    ours = found["least-squares"][-1]
    sets = ", ".join(" + ".join(names) for names in found["sets"])
    effects = run.truth["effects"]
    beside = (
        "The bars are what the camera's noise explains. Where a point lies far outside its bar, the arm does more than "
        "the geometric model knows: play and give of the joints have been taken for lengths and angles."
        if effects
        else "Nothing but geometry was injected, and the estimates lie on the truth within their bars."
    )
    return Section(
        slug="calibration",
        title="The arm, calibrated (Table 4)",
        lead=(
            f"Two methods on the same pictures, three times ({sets}). Least squares uses all four markers in pixels; "
            f"Algorithm 1, as in the paper, the tip alone. {ours['identifiable']} of the seven parameters can be known."
        ),
        blocks=(
            table(
                [
                    "parameter",
                    "paper (2nd)",
                    "truth",
                    "truth in our convention",
                    *(f"least squares {k + 1}" for k in range(len(found["sets"]))),
                    *(f"Algorithm 1, {k + 1}" for k in range(len(found["sets"]))),
                ],
                [_cells(row) for row in found["rows"]],
                "Calibrations on "
                + sets
                + ". ± is one standard deviation from the camera's noise; Algorithm 1 gives none.",
                marked=[4 + k for k in range(len(found["sets"]))],
            ),
            plot(_errors(found), beside),
            prose(
                "What cannot be known: "
                + "; ".join(ours["gauge"])
                + ". So the truth is moved along this gauge into the "
                "convention before estimates are compared with it. Table 4's separate Δl4, Δl5 and Δθ3 come from the "
                "starting vector of Algorithm 1, and they scatter little because every calibration starts there."
            ),
            plot(
                _singular(found),
                "How much better the pictures know each direction of the parameters than the drawing "
                "does, largest first. Below 1 (dashed) nothing is learned: the last direction is the gauge.",
            ),
        ),
    )


def _cells(row: dict[str, Any]) -> list[str]:
    scale, digits = (180.0 / np.pi, 3) if row["unit"] == "rad" else (1.0, 3)
    cells = [_SYMBOLS[row["parameter"]]]
    cells += [number(scale * v, digits) for v in (row["paper"][1], row["truth"], row["truth_in_convention"])]
    for method in _METHODS:
        for estimate in row[method]:
            std = estimate["std"]
            text = number(scale * estimate["value"], digits)
            cells.append(text if std is None else f"{text} ± {number(scale * std, digits)}")
    return cells


def _errors(found: dict[str, Any]) -> go.Figure:
    fig = figure("", "estimate − truth in the convention, mm or degrees", height=420)
    for method, (label, colour) in _METHODS.items():
        last = [(row, row[method][-1], 180.0 / np.pi if row["unit"] == "rad" else 1.0) for row in found["rows"]]
        truth = "truth_in_convention" if method == "least-squares" else "truth"
        fig.add_scatter(
            x=[_SYMBOLS[row["parameter"]] for row, _, _ in last],
            y=[scale * (estimate["value"] - row[truth]) for row, estimate, scale in last],
            error_y={"type": "data", "array": [1.96 * scale * (e["std"] or 0.0) for _, e, scale in last]},
            mode="markers",
            marker={"size": 9, "color": colour},
            name=f"{label}, all trajectories",
        )
    fig.add_hline(y=0, line={"color": COLOURS["truth"], "width": 1})
    return fig


def _singular(found: dict[str, Any]) -> go.Figure:
    values = [max(value or 0.0, 1e-6) for value in found["singular_values"]]
    fig = figure("direction", "singular value, units of the drawing's spread", height=320)
    fig.add_bar(x=list(range(1, len(values) + 1)), y=values, marker={"color": COLOURS["armtwin"]}, showlegend=False)
    fig.add_hline(y=1, line={"color": COLOURS["truth"], "dash": "dash"})
    fig.update_yaxes(type="log")
    return fig
