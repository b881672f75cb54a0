"""The arm's calibrations beside Table 4, and what of them can be known."""

from __future__ import annotations

from typing import Any

import numpy as np
import plotly.graph_objects as go
from markupsafe import Markup

from armtwin.models.statistics import Z95
from armtwin.scenarios.report.data import RunData
from armtwin.scenarios.report.section import Section, number, plot, prose, table
from armtwin.scenarios.report.style import COLOURS, figure

_METHODS = {
    "least-squares": ("least squares", COLOURS["armtwin"]),
    "algorithm-1": ("Algorithm 1", COLOURS["paper method"]),
}


def calibration_section(run: RunData) -> Section:
    """Show Table 4 by both methods, each estimate's distance from the truth, and the singular values."""
    found = run.results["tables"]["4"]
    ours = found["least-squares"][-1]
    sets = ", ".join(" + ".join(names) for names in found["sets"])
    covered = sum(_covers(row) for row in found["rows"])
    beside = (
        f"All trajectories together. Bars are 95 % intervals, as wide as the residuals make them; {covered} of the "
        f"{len(found['rows'])} hold the truth. A point far outside its bar is no accident: the arm then does more than "
        "its geometry, and play and give have been taken for lengths and angles."
    )
    return Section(
        slug="calibration",
        title="The arm, calibrated (Table 4)",
        lead=(_lead(found, sets)),
        blocks=(
            _table(found, "least-squares", "truth in our convention", "truth_in_convention", sets),
            *((_table(found, "algorithm-1", "truth", "truth", sets),) if "algorithm-1" in found else ()),
            plot(_errors(found), beside),
            *((_gauge(ours["gauge"]),) if ours["gauge"] else ()),
            plot(
                _singular(found),
                "How much better the pictures know each direction of the parameters than the drawing "
                "does, largest first. Below 1 (dashed) nothing is learned: the last direction is the gauge.",
            ),
        ),
    )


def _lead(found: dict[str, Any], sets: str) -> str:
    known = f"{found['least-squares'][-1]['identifiable']} of the"
    if "algorithm-1" not in found:
        return (
            f"Least squares on all markers in pixels, by each set of trajectories ({sets}). {known} "
            f"{len(found['rows'])} parameters can be known. Algorithm 1 and the paper's figures are of another arm."
        )
    return (
        f"Two methods on the same pictures, three times ({sets}). Least squares uses all four markers in pixels; "
        f"Algorithm 1, as in the paper, the tip alone. {known} seven parameters can be known."
    )


def _gauge(gauge: list[str]) -> Markup:
    return prose(
        "What cannot be known: " + "; ".join(gauge) + ". So the truth is moved along this gauge into the "
        "convention before estimates are compared with it. Table 4's separate Δl4, Δl5 and Δθ3 come from the "
        "starting vector of Algorithm 1, and they scatter little because every calibration starts there."
    )


def _table(found: dict[str, Any], method: str, truth: str, key: str, sets: str) -> Markup:
    """Return Table 4 as one method finds it; the truth stands in the convention that the method's answer has."""
    label = _METHODS[method][0]
    numbers = range(len(found["sets"]))
    rows = []
    for row in found["rows"]:
        scale = _scale(row)
        printed = ["–"] * 3 if row["paper"] is None else [number(scale * value, 3) for value in row["paper"][:3]]
        cells = [_symbol(row), *printed]
        cells.append(number(scale * row[key], 3))
        for estimate in row[method]:
            text = number(scale * estimate["value"], 3)
            cells.append(text if estimate["std"] is None else f"{text} ± {number(scale * estimate['std'], 3)}")
        rows.append(cells)
    spread = "± one standard deviation, from the residuals" if method == "least-squares" else "no deviations are known"
    return table(
        ["parameter", "paper, 1st", "paper, 2nd", "paper, 3rd", truth, *(f"{label}, {k + 1}" for k in numbers)],
        rows,
        f"{label[0].upper()}{label[1:]} on {sets}; {spread}.",
        marked=[5 + k for k in numbers],
    )


def _used(found: dict[str, Any]) -> dict[str, tuple[str, str]]:
    return {method: shown for method, shown in _METHODS.items() if method in found}


def _covers(row: dict[str, Any]) -> bool:
    low, high = row["least-squares"][-1]["interval95"]
    return bool(low <= row["truth_in_convention"] <= high)


def _symbol(row: dict[str, Any]) -> str:
    """Return `Δl1, mm` for `delta_l1_mm`."""
    _, name, unit = row["parameter"].split("_")
    return f"Δ{name.replace('theta', 'θ')}, {'°' if unit == 'rad' else unit}"


def _scale(row: dict[str, Any]) -> float:
    return 180.0 / np.pi if row["unit"] == "rad" else 1.0


def _errors(found: dict[str, Any]) -> go.Figure:
    fig = figure("", "estimate − truth, mm or degrees", height=420)
    for method, (label, colour) in _used(found).items():
        last = [(row, row[method][-1], _scale(row)) for row in found["rows"]]
        truth = "truth_in_convention" if method == "least-squares" else "truth"
        fig.add_scatter(
            x=[_symbol(row) for row, _, _ in last],
            y=[scale * (estimate["value"] - row[truth]) for row, estimate, scale in last],
            error_y={"type": "data", "array": [Z95 * scale * (e["std"] or 0.0) for _, e, scale in last]},
            mode="markers",
            marker={"size": 9, "color": colour},
            name=f"{label}, all trajectories",
        )
    fig.add_hline(y=0, line={"color": COLOURS["truth"], "width": 1})
    return fig


def _singular(found: dict[str, Any]) -> go.Figure:
    values = [max(value or 0.0, 1e-6) for value in found["singular_values"]]
    fig = figure("direction", "singular value", height=320)
    fig.add_bar(x=list(range(1, len(values) + 1)), y=values, marker={"color": COLOURS["armtwin"]}, showlegend=False)
    fig.add_hline(y=1, line={"color": COLOURS["truth"], "dash": "dash"})
    fig.update_yaxes(type="log")
    return fig
