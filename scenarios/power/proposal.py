"""A proposed plan, held against the one that it is to better: for people and as data."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict
from typing import Any

import numpy as np
import plotly.graph_objects as go
from numpy.typing import NDArray

from armtwin.scenarios.power.design import Design, design
from armtwin.scenarios.power.ground import Ground, faults_of
from armtwin.scenarios.power.power import Power
from armtwin.scenarios.power.setting import Setting
from armtwin.scenarios.report.section import Section, fold, number, plot, table
from armtwin.scenarios.report.style import COLOURS, figure
from armtwin.sim.sealed.plans import joint_ranges

Array = NDArray[np.float64]

SCHEMA = "armtwin.design/1"
_SIZES = ("fault", "half the size", "the size found in 90 of 100", "twice the size")
_TICKS = (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10)
_INDICES = {
    "o1": "O1, geometric mean over the root of the poses",
    "o2": "O2, smallest over largest",
    "o3": "O3, smallest",
    "o4": "O4, noise amplification index",
    "o5": "O5, inverse of the sum of inverses",
}


def propose(result: Power, n: int, goal: Array | None, *, add: bool, progress: Callable[[int, int], None]) -> Design:
    """Propose `n` poses (or as many more) that show the faults of a power, and make the error on a path small."""
    setting = result.setting
    ground = Ground(setting, faults_of(result), goal)
    return design(ground, setting.plan, n, joint_ranges(setting.drawing), add=add, progress=progress)


def told(proposed: Design, setting: Setting) -> str:
    """Say in a sentence what a proposal gains."""
    good = sum(ratio >= 1.0 for ratio in proposed.ratios.values())
    path = ""
    if proposed.path_before_mm is not None and proposed.path_after_mm is not None:
        path = f" On the path the geometry's error goes from {proposed.path_before_mm:.3f} to "
        path += f"{proposed.path_after_mm:.3f} mm."
    return (
        f"With {len(proposed.plan)} poses {good} of {len(proposed.ratios)} faults are found at the size for which the "
        f"old plan takes {len(setting.plan)}.{path}"
    )


def design_table(proposed: Design) -> dict[str, Any]:
    """Return the content of `design.json`."""
    return {
        "schema": SCHEMA,
        "poses": len(proposed.plan),
        "worth_over_needed": proposed.ratios,
        "worth_over_old_plan_at_half_the_size": proposed.at_half,
        "worth_over_old_plan_at_twice_the_size": proposed.at_twice,
        "observability": {"before": asdict(proposed.before), "after": asdict(proposed.after)},
        "path_error_mm": {"before": proposed.path_before_mm, "after": proposed.path_after_mm},
    }


def design_section(proposed: Design, setting: Setting) -> Section:
    """Return the page's section on a proposal."""
    before, after = asdict(proposed.before), asdict(proposed.after)
    rows = [(words, number(before[name], 3), number(after[name], 3)) for name, words in _INDICES.items()]
    caption = "Smallest size found in 90 of 100, new plan over old: left of the line the new plan sees smaller faults."
    told_sizes = "What a fault is worth on the new plan over the old: at 1 both find it alike"
    blocks = (
        plot(_gains(proposed), caption),
        fold("At half and at twice these sizes", (table(_SIZES, _by_size(proposed), told_sizes, marked=(2,)),)),
        plot(_poses(proposed, setting), "Commands of the proposed poses, in their order"),
        table(("index", "old plan", "new plan"), rows, "Observability of the geometry; larger is better", marked=(2,)),
    )
    return Section("design", "Better poses", told(proposed, setting), blocks)


def _by_size(proposed: Design) -> list[tuple[str, ...]]:
    return [
        (name, number(proposed.at_half[name], 2), number(ratio, 2), number(proposed.at_twice[name], 2))
        for name, ratio in sorted(proposed.ratios.items(), key=lambda row: row[1])
    ]


def _gains(proposed: Design) -> go.Figure:
    shown = sorted(proposed.ratios.items(), key=lambda row: row[1])
    fig = figure("size, new plan over old", "", height=130 + 20 * len(shown))
    sizes = [1.0 / np.sqrt(ratio) for _, ratio in shown]
    colours = [COLOURS["extended"] if size <= 1.0 else COLOURS["geometry"] for size in sizes]
    fig.add_scatter(x=sizes, y=[name for name, _ in shown], mode="markers", marker={"color": colours, "size": 9})
    fig.add_vline(x=1.0, line_dash="dash", line_color=COLOURS["truth"])
    fig.update_xaxes(type="log", tickvals=_TICKS, ticktext=[f"{tick:g}" for tick in _TICKS])
    fig.update_yaxes(tickfont_size=11)
    fig.update_layout(margin={"l": 165}, showlegend=False)
    return fig


def _poses(proposed: Design, setting: Setting) -> go.Figure:
    fig = figure("pose", "command, degrees", height=320)
    colours = (COLOURS["armtwin"], COLOURS["paper method"], COLOURS["paper"], *COLOURS.values())
    for joint, (colour, q) in enumerate(zip(colours, proposed.plan.q_cmd.T, strict=False), start=1):
        fig.add_scatter(
            y=np.degrees(q), mode="lines+markers", name=f"joint {joint}", line={"color": colour, "width": 1}
        )
    return fig
