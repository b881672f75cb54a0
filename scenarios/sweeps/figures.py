"""The figures of a sweep: found against size, what is said of what, the map over noise and poses."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence

import numpy as np
import plotly.graph_objects as go
from numpy.typing import NDArray

from armtwin.scenarios.power.place import PlacePower
from armtwin.scenarios.power.words import axis, shown_size, unit_words
from armtwin.scenarios.report.style import COLOURS, add_band, figure
from armtwin.scenarios.sweeps.curve import wilson
from armtwin.scenarios.sweeps.summary import CellSummary

Array = NDArray[np.float64]

_TRIALS, _PREDICTED = COLOURS["extended"], COLOURS["geometry"]
_BINS = 9
_POINTS = 60
_HEIGHT = 300
# What is said in less than this share of an effect's worlds is summed up.
_RARE = 0.03
_OTHERS = "others"


def found_curve(one: CellSummary, predicted: Sequence[PlacePower] = ()) -> go.Figure:
    """Return found against size: trials with their intervals, the fitted curve with its band, power's prediction."""
    fig = figure(axis(one.unit), "found", height=_HEIGHT, title=title_of(one))
    assert one.curve is not None
    sizes = np.array([row["size"] for row in one.rows])
    grid = np.geomspace(sizes.min(), sizes.max(), _POINTS)
    share = np.array([one.curve.share(float(size)) for size in grid])
    x = shown_size(grid, one.unit)
    add_band(fig, x.tolist(), share[:, 1].tolist(), share[:, 2].tolist(), _TRIALS)
    fig.add_scatter(x=x, y=share[:, 0], mode="lines", name="trials, fitted", line={"color": _TRIALS, "width": 2})
    _points(fig, one, sizes)
    if predicted:
        mean, low, high = (
            np.mean([_on(grid, p, what) for p in predicted], axis=0) for what in ("found", "low", "high")
        )
        add_band(fig, x.tolist(), low.tolist(), high.tolist(), _PREDICTED)
        line = {"color": _PREDICTED, "width": 2, "dash": "dash"}
        fig.add_scatter(x=x, y=mean, mode="lines", name="power", line=line)
    fig.update_xaxes(type="log", dtick=1)
    fig.update_yaxes(range=[-0.03, 1.03], tickformat=".0%")
    fig.update_layout(legend={"y": -0.45, "yanchor": "top"}, margin={"b": 95, "t": 50})
    return fig


def title_of(one: CellSummary) -> str:
    """Return what tells a cell from the others, for people."""
    place = "" if one.cell.place == "any" else f", {one.cell.place}"
    return f"{one.cell.effect}{place}; {one.cell.poses} poses, {one.cell.noise_px:g} px"


def confusion_map(said: Mapping[str, Counter[str]]) -> go.Figure:
    """Return what is said of each effect as shares of its worlds."""
    names = list(said)
    common = [
        answer
        for answer in dict.fromkeys(a for counts in said.values() for a, _ in counts.most_common())
        if any(counts[answer] > _RARE * sum(counts.values()) for counts in said.values()) and "|" not in answer
    ]
    columns = [*sorted(common, key=lambda a: names.index(a) if a in names else len(names)), "a tie with it", _OTHERS]
    z = np.zeros((len(names), len(columns)))
    for row, name in enumerate(names):
        total = sum(said[name].values())
        for answer, count in said[name].items():
            tie = "|" in answer and name in answer.split("|")
            column = answer if answer in columns else "a tie with it" if tie else _OTHERS
            z[row, columns.index(column)] += count / total
    fig = figure("what is said", "", height=180 + 22 * len(names))
    fig.add_heatmap(
        z=z,
        x=columns,
        y=names,
        colorscale=[[0.0, "#ffffff"], [1.0, _TRIALS]],
        zmin=0.0,
        zmax=1.0,
        xgap=1,
        ygap=1,
        colorbar={"tickformat": ".0%", "thickness": 10},
        hovertemplate="%{y}: %{z:.0%} %{x}<extra></extra>",
    )
    fig.update_yaxes(autorange="reversed", tickfont_size=10)
    fig.update_xaxes(tickangle=-60, tickfont_size=10)
    fig.update_layout(margin={"l": 130, "b": 130})
    return fig


def size_map(cells: Sequence[CellSummary]) -> go.Figure:
    """Return the size found in 90 of 100 against the noise, a line for each number of poses, of one effect."""
    unit = cells[0].unit
    fig = figure(
        "noise, px", f"found in 90 of 100 from, {unit_words(unit)}", height=_HEIGHT, title=cells[0].cell.effect
    )
    colours = (COLOURS["drawing"], COLOURS["armtwin"], COLOURS["extended"], COLOURS["truth"], COLOURS["paper"])
    for colour, poses in zip(colours, sorted({one.cell.poses for one in cells}), strict=False):
        line = [one for one in cells if one.cell.poses == poses and one.ninety.size is not None]
        line.sort(key=lambda one: one.cell.noise_px)
        x = [one.cell.noise_px for one in line]
        low = [one.ninety.low or one.ninety.size for one in line]
        high = [one.ninety.high or one.ninety.size for one in line]
        add_band(fig, x, shown_size(np.array(low), unit).tolist(), shown_size(np.array(high), unit).tolist(), colour)
        y = shown_size(np.array([one.ninety.size for one in line]), unit)
        fig.add_scatter(x=x, y=y, mode="lines+markers", name=f"{poses} poses", line={"color": colour})
    fig.update_xaxes(type="log", dtick="D2")
    fig.update_yaxes(type="log", dtick=1)
    fig.update_layout(legend={"y": -0.45, "yanchor": "top"}, margin={"b": 95, "t": 50})
    return fig


def _points(fig: go.Figure, one: CellSummary, sizes: Array) -> None:
    """Add the shares of neighbouring trials with their intervals of 90 %."""
    order = np.argsort(sizes)
    found = np.array([row["found"] for row in one.rows])
    x, y, up, down = [], [], [], []
    for part in np.array_split(order, min(_BINS, max(len(order) // 3, 1))):
        hits, of = int(found[part].sum()), len(part)
        low, high = wilson(hits, of)
        x.append(float(shown_size(np.exp(np.log(sizes[part]).mean()), one.unit)))
        y.append(hits / of)
        up.append(high - hits / of)
        down.append(hits / of - low)
    error = {"type": "data", "array": up, "arrayminus": down, "color": _TRIALS, "thickness": 1, "width": 0}
    fig.add_scatter(x=x, y=y, error_y=error, mode="markers", name="trials", marker={"color": _TRIALS, "size": 7})


def _on(grid: Array, one: PlacePower, what: str) -> Array:
    return np.interp(np.log(grid), np.log(one.sizes), getattr(one, what))
