"""The vision system's evaluation beside Table 3."""

from __future__ import annotations

from typing import Any

import plotly.graph_objects as go

from armtwin.scenarios.report.data import RunData
from armtwin.scenarios.report.section import Section, gallery, number, plot, table
from armtwin.scenarios.report.style import COLOURS, figure
from armtwin.scenarios.runner.frames import read_frame

_NAMES = {"paper": "paper's detector, here", "subpixel": "sub-pixel, here"}
_COLOURS = {"paper": COLOURS["paper method"], "subpixel": COLOURS["armtwin"]}


def gauge_section(run: RunData) -> Section:
    """Show bias, mean square error and U of every gauge for the paper and for both detectors."""
    rows = run.results["tables"]["3"]
    worst = {name: worst_of([row for row in rows if row["detector"] == name]) for name in _NAMES}
    lengths = [r["length_mm"] for r in rows if r["detector"] == "subpixel"]
    pictures = [
        (f"{length:g} mm", read_frame(run.out / "gauges", number)[::2, ::2]) for number, length in enumerate(lengths)
    ]
    return Section(
        slug="gauges",
        title="How well the camera measures (Table 3)",
        lead=(
            f"Gauges of known length, placed anywhere in the arm's plane: the sub-pixel detector is never worse than "
            f"{worst['subpixel']:.3f} mm in bias or spread, the paper's chain {worst['paper']:.2f} mm, in the same "
            "pictures."
        ),
        blocks=(
            plot(
                _biases(rows),
                "Average measured length less the true one; bars are ± U (equation 24). The paper's bias is the same "
                "at 5 and at 40 mm: an edge seen too far out, not a wrong scale.",
            ),
            table(
                ["length, mm", "detector", "average, mm", "bias, mm", "mean square, mm²", "U, mm", "missed"],
                [cells for row in sorted(rows, key=_by_length) for cells in _cells(row)],
                f"Table 3, {rows[0]['n'] + rows[0]['missed']} placements each.",
            ),
            gallery(
                pictures,
                "The first placement of each gauge: a block with two discs whose centres are its length apart.",
                columns=4,
            ),
        ),
    )


def worst_of(rows: list[dict[str, Any]]) -> float:
    """Return the largest bias or spread of gauges, mm; NaN where none was measured."""
    values = [max(abs(row["bias_mm"]), row["uncertainty_mm"]) for row in rows if row["bias_mm"] is not None]
    return max(values, default=float("nan"))


def _by_length(row: dict[str, Any]) -> tuple[float, str]:
    return -row["length_mm"], row["detector"]


def _cells(row: dict[str, Any]) -> list[list[str]]:
    ours = [
        number(row["length_mm"], 0),
        _NAMES[row["detector"]],
        number(row["average_mm"]),
        number(row["bias_mm"]),
        number(row["mean_square_error_mm2"], 6),
        number(row["uncertainty_mm"]),
        str(row["missed"]),
    ]
    paper = row["paper"]
    if row["detector"] != "paper" or paper is None:
        return [ours]
    printed = [
        number(row["length_mm"], 0),
        "the paper",
        number(paper["average_mm"]),
        number(paper["bias_mm"]),
        number(paper["mean_square_error_mm2"], 4),
        number(paper["uncertainty_mm"]),
        "–",
    ]
    return [printed, ours]


def _biases(rows: list[dict[str, Any]]) -> go.Figure:
    fig = figure("length of the gauge, mm", "bias ± U, mm")
    printed = [r["paper"] for r in rows if r["detector"] == "paper" and r["paper"] is not None]
    series = [("the paper (Table 3)", COLOURS["paper"], printed)]
    series += [
        (_NAMES[d], _COLOURS[d], [r for r in rows if r["detector"] == d and r["bias_mm"] is not None]) for d in _NAMES
    ]
    for shift, (name, colour, values) in enumerate(series):
        fig.add_scatter(
            x=[r["length_mm"] + 0.35 * (shift - 1) for r in values],
            y=[r["bias_mm"] for r in values],
            error_y={"type": "data", "array": [r["uncertainty_mm"] for r in values], "thickness": 1.5},
            mode="markers",
            marker={"size": 9, "color": colour},
            name=name,
        )
    fig.add_hline(y=0, line={"color": COLOURS["truth"], "width": 1})
    return fig
