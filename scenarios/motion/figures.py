"""The figures of a moving arm: the command, what was measured, and both twins over time, and what each leaves."""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go
from numpy.typing import NDArray

from armtwin.calib.motion.diagnosis import MotionDiagnosis
from armtwin.scenarios.report.style import COLOURS, figure

Array = NDArray[np.float64]

_STRETCH_S = 6.0
# Points of a figure: more are not seen, and make the page heavy.
_MOST_POINTS = 1500
_MEASURED = COLOURS["armtwin"]
_MOST_LAG_S = 0.4


def stretch(found: MotionDiagnosis, joint: int, *, titled: bool = True) -> go.Figure:
    """Return the stretch of a joint in which the causes change most: command, measurement and both twins, degrees.

    One that is `titled` has no legend of its own.
    """
    rows = telling_rows(found, joint)
    time = found.recording.time_s[rows]
    fig = figure("time, s", "angle, degrees", height=340, title=stretch_words(found, joint) if titled else None)
    fig.update_layout(showlegend=not titled)
    commanded = {"color": COLOURS["commanded"], "width": 1.5, "shape": "hv"}
    fig.add_scatter(x=time, y=np.degrees(found.recording.q_cmd[rows, joint]), name="commanded", line=commanded)
    for which, name in (("before", "calibrated geometry"), ("after", "extended twin")):
        colour = COLOURS["geometry" if which == "before" else "extended"]
        angle = np.degrees(found.predicted_joint(which, joint)[rows])
        fig.add_scatter(x=time, y=angle, name=name, line={"color": colour, "width": 2})
    dots = {"color": _MEASURED, "size": 4}
    fig.add_scatter(
        x=time, y=np.degrees(found.recording.q_meas[rows, joint]), name="measured", mode="markers", marker=dots
    )
    return fig


def phase_plane(found: MotionDiagnosis, joint: int) -> list[go.Figure]:
    """Return what both twins leave over the angle and the speed of a joint, milliradians."""
    rows = _thinned(np.flatnonzero(found.problem.series[joint].used))
    speed = np.gradient(found.predicted_joint("after", joint), found.recording.time_s)
    limit = 1e3 * float(np.quantile(np.abs(_left(found, "before", joint)[rows]), 0.98)) or 1.0
    figures = []
    for which, name in (("before", "before: calibrated geometry"), ("after", "after: extended twin")):
        fig = figure("angle, degrees", "speed, degrees/s", height=340, title=name)
        marker = {
            "color": 1e3 * _left(found, which, joint)[rows],
            "colorscale": "RdBu",
            "cmin": -limit,
            "cmax": limit,
            "size": 4,
            "colorbar": {"title": "mrad", "thickness": 12},
        }
        fig.add_scatter(
            x=np.degrees(found.recording.q_meas[rows, joint]),
            y=np.degrees(speed[rows]),
            mode="markers",
            marker=marker,
            showlegend=False,
        )
        figures.append(fig)
    return figures


def error_over_time(found: MotionDiagnosis, joint: int) -> go.Figure:
    """Return what both twins leave over all of the recording, milliradians."""
    rows = _thinned(np.arange(len(found.recording)))
    fig = figure("time, s", "predicted less measured, mrad", height=300, title=found.recording.joint_names[joint])
    for which, name in (("before", "calibrated geometry"), ("after", "extended twin")):
        colour = COLOURS["geometry" if which == "before" else "extended"]
        fig.add_scatter(
            x=found.recording.time_s[rows],
            y=1e3 * _left(found, which, joint)[rows],
            mode="markers",
            name=name,
            marker={"color": colour, "size": 3},
        )
    fig.update_layout(showlegend=False)
    return fig


def delay_by_correlation(found: MotionDiagnosis) -> go.Figure:
    """Return how alike the speeds of command and measurement are, over the delay between them, joint by joint."""
    fig = figure("delay of the measurement, ms", "correlation of the speeds", height=340)
    step = float(np.median(np.diff(found.recording.time_s)))
    lags = np.arange(0, max(2, round(_MOST_LAG_S / step)))
    for joint, name in enumerate(found.recording.joint_names):
        if not found.problem.moves(joint):
            continue
        series = found.problem.series[joint]
        sent, seen = np.diff(series.sent), np.diff(series.measured)
        values = [float(np.corrcoef(sent[: len(sent) - k], seen[k:])[0, 1]) for k in lags if np.ptp(seen[k:]) > 0]
        fig.add_scatter(
            x=1e3 * step * lags[: len(values)], y=values, mode="lines+markers", name=name, marker={"size": 4}
        )
    return fig


def telling_rows(found: MotionDiagnosis, joint: int) -> NDArray[np.intp]:
    """Return the rows of the stretch, inside one motion, in which the two twins differ most."""
    recording = found.recording
    apart = (found.predicted_joint("before", joint) - found.predicted_joint("after", joint)) ** 2
    moved = np.abs(np.gradient(recording.q_meas[:, joint]))
    weight = apart + 1e-9 * np.nan_to_num(moved)
    total = np.append(0.0, np.cumsum(weight))
    end = np.searchsorted(recording.time_s, recording.time_s + _STRETCH_S)
    number = np.cumsum(recording.first)
    end = np.minimum(end, np.searchsorted(number, number, side="right"))
    best = int(np.argmax(total[end] - total[:-1]))
    return np.arange(best, end[best])


def _left(found: MotionDiagnosis, which: str, joint: int) -> Array:
    return found.predicted_joint(which, joint) - found.problem.series[joint].measured


def _thinned(rows: NDArray[np.intp]) -> NDArray[np.intp]:
    return rows[:: max(1, -(-len(rows) // _MOST_POINTS))]


def stretch_words(found: MotionDiagnosis, joint: int) -> str:
    """Return which joint in which motion a stretch shows."""
    rows = telling_rows(found, joint)
    return f"{found.recording.joint_names[joint]} in {found.recording.trajectory[rows[0]]}"
