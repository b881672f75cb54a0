"""The figures of a diagnosis. Before is the calibrated geometry alone, after the extended twin, each in its colour."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import plotly.graph_objects as go
from numpy.typing import NDArray

from armtwin.calib.diagnosis.diagnosis import Diagnosis
from armtwin.scenarios.diagnosis.ranking import Ranked
from armtwin.scenarios.diagnosis.remainder import Remainder
from armtwin.scenarios.diagnosis.structure import DIRECTIONS, ResidualPlot, groups_of
from armtwin.scenarios.report.style import COLOURS, figure

Array = NDArray[np.float64]

BEFORE, AFTER = COLOURS["geometry"], COLOURS["extended"]
# One a joint; none is the colour of before or after.
_JOINTS = ("#0072b2", "#cc79a7", "#e69f00", "#8a8a8a", "#222222", "#56b4e9")
# The longest arrows, but for a few, are drawn this long.
_ARROW_MM = 14.0
_MOST_ARROWS = 260
# Head of an arrow: its strokes' length against the shaft's, and their angle to it.
_HEAD, _HEAD_RAD = 0.28, 0.45
_SPREAD = 0.16
# Percent to the right end of an axis that leaves room for a bar's value and a word on a phone.
_BAR_AND_WORD = 190
# Likewise on a logarithmic axis, as a share of its length.
_ROOM = 0.6
_TAG = {"before": "before: calibrated geometry", "after": "after: extended twin"}


def arrows(before: Remainder, after: Remainder | None) -> tuple[list[go.Figure], float]:
    """Return the residuals of every marker as arrows in the robot's plane, and the factor that enlarges all of them."""
    assert before.points_mm is not None
    sizes = np.linalg.norm(before.miss_mm, axis=-1)
    sizes = sizes[np.isfinite(sizes)]
    factor = _round_down(_ARROW_MM / max(float(np.percentile(sizes, 97)), 1e-6)) if len(sizes) else 1.0
    panels = [("before", before, BEFORE)] + ([] if after is None else [("after", after, AFTER)])
    rows = np.unique(np.linspace(0, len(before.miss_mm) - 1, _MOST_ARROWS).round().astype(int))
    figures = []
    for name, shown, colour in panels:
        # Both at the same places: a camera that is thought to stand elsewhere moves the whole arm with it.
        at, miss = before.points_mm[rows].reshape(-1, 2), shown.miss_mm[rows].reshape(-1, 2)
        x, y = _strokes(at[:, 0] + 1j * at[:, 1], factor * (miss[:, 0] + 1j * miss[:, 1]))
        fig = figure("x, mm", "y, mm", height=480, title=_TAG[name])
        fig.add_scatter(x=x, y=y, mode="lines", line={"width": 1.2, "color": colour}, hoverinfo="skip")
        fig.update_xaxes(range=_range(before.points_mm[..., 0]), constrain="domain")
        fig.update_yaxes(range=_range(before.points_mm[..., 1]), scaleanchor="x", constrain="domain")
        fig.update_layout(showlegend=False)
        figures.append(fig)
    return figures, factor


def residual_figure(shown: ResidualPlot) -> go.Figure:
    """Return one telling plot, before and after."""
    fig = figure(shown.ordinate.title, shown.component.title, height=420)
    for trace in _residual_traces(shown, with_legend=True):
        fig.add_trace(trace)
    _directions(fig, shown)
    return fig


def residual_figures(plots: Sequence[ResidualPlot]) -> list[go.Figure]:
    """Return the other plots as small ones."""
    figures = []
    for shown in plots:
        title = f"{shown.ordinate.against}: {_shares(shown)}"
        fig = figure(shown.ordinate.title, shown.component.title, height=330, title=title)
        for trace in _residual_traces(shown, with_legend=False):
            fig.add_trace(trace)
        _directions(fig, shown)
        fig.update_layout(showlegend=False)
        figures.append(fig)
    return figures


def candidates(ranked: Sequence[Ranked]) -> go.Figure:
    """Return how much of what was to be explained each effect alone explains, fitted jointly with the geometry."""
    colours = {"named": AFTER, "tied": COLOURS["drawing"], "": "#c4c4c4"}
    fig = figure("explained alone, %", "", height=120 + 26 * len(ranked))
    shown = list(reversed(ranked))
    fig.add_bar(
        x=[100.0 * one.explained_share for one in shown],
        y=[one.label for one in shown],
        orientation="h",
        marker_color=[colours[one.standing] for one in shown],
        text=[f"{100.0 * one.explained_share:.1f}{f'  {one.standing}' if one.standing else ''}" for one in shown],
        textposition="outside",
        cliponaxis=False,
    )
    fig.update_xaxes(range=[0, _BAR_AND_WORD], tickvals=[0, 50, 100])
    fig.update_yaxes(tickfont_size=11)
    fig.update_layout(margin={"l": 170}, showlegend=False)
    return fig


def held_out_bars(diagnosis: Diagnosis, resimulated_mm: float) -> go.Figure:
    """Return the error on held-out poses of each twin, against the noise floor."""
    held = diagnosis.held_out
    bars = [
        ("the drawing", held.nominal_rms_mm, COLOURS["commanded"]),
        ("calibrated geometry", held.before_rms_mm, BEFORE),
        ("extended twin", held.after_rms_mm if diagnosis.explanation.final.effects else np.nan, AFTER),
        ("twin in MuJoCo", resimulated_mm, AFTER),
    ]
    bars = [bar for bar in bars if np.isfinite(bar[1]) and bar[1] > 0]
    fig = figure("held-out RMS, mm", "", height=270)
    for name, value, colour in reversed(bars):
        fig.add_bar(
            x=[value], y=[name], orientation="h", marker_color=colour, text=f"  {value:.3g} mm", textposition="outside"
        )
    floor = held.noise_floor_mm
    fig.add_vline(x=floor, line_dash="dash", line_color=COLOURS["truth"])
    # On a logarithmic axis annotations stand at the logarithm.
    fig.add_annotation(x=np.log10(floor), y=1.0, yref="paper", yanchor="bottom", showarrow=False, text="noise floor")
    least = min([floor, *(value for _, value, _ in bars)])
    most = max([floor, *(value for _, value, _ in bars)])
    fig.update_xaxes(
        type="log", range=[np.log10(least) - 0.4, np.log10(most) + _ROOM * np.log10(most / least) + 0.3], dtick=1
    )
    fig.update_yaxes(tickfont_size=11)
    fig.update_layout(showlegend=False, margin={"l": 125})
    return fig


def held_out_poses(diagnosis: Diagnosis, before: Remainder, after: Remainder | None) -> go.Figure:
    """Return the RMS miss of each held-out pose, before and after."""
    rows = np.flatnonzero(diagnosis.held_rows)
    fig = figure("held-out pose, in the order they happened", "RMS miss of the pose, mm", height=330)
    for name, remainder, colour in (("before", before, BEFORE), ("after", after, AFTER)):
        if remainder is not None:
            dots = {"color": colour, "size": 6}
            fig.add_scatter(x=rows, y=remainder.size_mm[rows], mode="markers", marker=dots, name=_TAG[name])
    fig.add_hline(
        y=diagnosis.held_out.noise_floor_mm, line_dash="dash", line_color=COLOURS["truth"], annotation_text="noise"
    )
    fig.update_yaxes(rangemode="tozero")
    return fig


def _residual_traces(shown: ResidualPlot, with_legend: bool) -> list[go.Scatter]:
    traces = []
    rng = np.random.default_rng(0)
    for name, values, colour in (("before", shown.component.before, BEFORE), ("after", shown.component.after, AFTER)):
        if values is None:
            continue
        x = shown.ordinate.values
        if shown.ordinate.is_direction:  # spread out, so that points do not hide one another
            x = x + rng.uniform(-_SPREAD, _SPREAD, len(x))
        dots = {"color": colour, "size": 4 if with_legend else 3, "opacity": 0.45}
        traces.append(go.Scatter(x=x, y=values, mode="markers", marker=dots, showlegend=False, hoverinfo="x+y"))
        groups = groups_of(shown.ordinate, np.isfinite(values))
        traces.append(
            go.Scatter(
                x=[float(np.mean(shown.ordinate.values[group])) for group in groups],
                y=[float(np.mean(values[group])) for group in groups],
                mode="lines+markers",
                line={"color": colour, "width": 3},
                marker={"size": 7, "line": {"color": "#fff", "width": 1}},
                name=_TAG[name],
                showlegend=with_legend,
            )
        )
    return traces


def _directions(fig: go.Figure, shown: ResidualPlot) -> None:
    if shown.ordinate.is_direction:
        fig.update_xaxes(tickvals=list(DIRECTIONS), ticktext=list(DIRECTIONS.values()), range=[-1.6, 1.6])


def _strokes(
    at: NDArray[np.complex128], arrow: NDArray[np.complex128]
) -> tuple[list[float | None], list[float | None]]:
    """Return shaft and both strokes of the head of each arrow as one broken line."""
    x: list[float | None] = []
    y: list[float | None] = []
    for root, shaft in zip(at[np.isfinite(arrow)].tolist(), arrow[np.isfinite(arrow)].tolist(), strict=True):
        end = root + shaft
        left, right = (end - _HEAD * shaft * np.exp(1j * side * _HEAD_RAD) for side in (1, -1))
        for point in (root, end, left, end, right):
            x.append(float(np.real(point)))
            y.append(float(np.imag(point)))
        x.append(None)
        y.append(None)
    return x, y


def _range(values: Array) -> list[float]:
    return [float(np.nanmin(values)) - 1.2 * _ARROW_MM, float(np.nanmax(values)) + 1.2 * _ARROW_MM]


def _round_down(factor: float) -> float:
    """Return the largest of 1, 2, 5 times a power of ten that is not above `factor`."""
    power = 10.0 ** np.floor(np.log10(factor))
    return float(max(step for step in (power, 2 * power, 5 * power) if step <= factor * (1 + 1e-9)))


def _shares(shown: ResidualPlot) -> str:
    """Write the share that follows the ordinate, before and after."""
    shares = [share for share in (shown.share_before, shown.share_after) if share is not None]
    return " → ".join(f"{100.0 * share:.0f} %" for share in shares)


def plan(q_cmd: Array) -> go.Figure:
    """Return the commands (N, n) of a proposed experiment, rad, in degrees over the poses."""
    fig = figure("pose of the experiment", "commanded angle, °", height=300)
    for joint, colour in zip(range(q_cmd.shape[1]), _JOINTS, strict=False):
        shown = {"mode": "lines+markers", "line": {"color": colour, "width": 1.5}, "marker": {"size": 4}}
        fig.add_scatter(x=np.arange(len(q_cmd)), y=np.degrees(q_cmd[:, joint]), name=f"joint {joint + 1}", **shown)
    return fig
