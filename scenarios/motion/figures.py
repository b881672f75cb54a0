"""The figures of a moving arm: the command, what was measured, and both twins over time, and what each leaves."""

from __future__ import annotations

import numpy as np
import plotly.graph_objects as go
from numpy.typing import NDArray

from armtwin.calib.motion.diagnosis import MotionDiagnosis
from armtwin.calib.motion.likeness import likeness
from armtwin.scenarios.report.style import COLOURS, figure

Array = NDArray[np.float64]

_STRETCH_S = 3.0
# Points of a figure: more are not seen, and make the page heavy.
_MOST_POINTS = 1500
_MOST_LAG_S, _ALIKE = 0.4, 0.5
_MEASURED = COLOURS["armtwin"]


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


def what_to_see(found: MotionDiagnosis, joint: int) -> str:
    """Return what the eye should see in a joint's stretch, in words."""
    rows = telling_rows(found, joint)
    before, after = (np.abs(_left(found, which, joint)[rows]) for which in ("before", "after"))
    behind = _behind(found, joint, rows)
    words = stretch_words(found, joint)
    return (
        f"{words[0].upper()}{words[1:]}, where the causes change most: the dots run {behind} the grey command; orange "
        f"is off them by up to {np.degrees(before.max()):.2g}°, green by {np.degrees(after.max()):.2g}°."
    )


def _behind(found: MotionDiagnosis, joint: int, rows: NDArray[np.intp]) -> str:
    """Say how long the readings of a stretch come after its commands."""
    alike = likeness(found.recording, rows)
    near = (alike.lag_s >= 0.0) & (alike.lag_s < _MOST_LAG_S)  # a swing is like itself again a period later
    curve, lag_s = alike.correlation[joint, joint, near], alike.lag_s[near]
    best = int(np.argmax(curve))
    return f"about {1e3 * lag_s[best]:.0f} ms behind" if curve[best] > _ALIKE and best else "beside"


def stretch_words(found: MotionDiagnosis, joint: int) -> str:
    """Return which joint in which motion a stretch shows."""
    rows = telling_rows(found, joint)
    return f"{found.recording.joint_names[joint]} in {found.recording.trajectory[rows[0]]}"
