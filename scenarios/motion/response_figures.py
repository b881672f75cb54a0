"""Figures of how a joint answers: over frequency at several amplitudes, to single steps, and to its commands' delay."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import plotly.graph_objects as go
from numpy.typing import NDArray

from armtwin.calib.motion.diagnosis import MotionDiagnosis
from armtwin.calib.motion.frequency import Response, responses
from armtwin.calib.motion.likeness import likeness
from armtwin.scenarios.report.style import COLOURS, figure

Array = NDArray[np.float64]

# From small swings to large ones.
_SIZES = ("#56b4e9", "#0072b2", "#222222")
_STEP_RAD, _QUIET_S, _SHOWN_S = 0.05, 0.25, 0.6
_MOST_STEPS = 12


def frequency_response(found: MotionDiagnosis, joint: int) -> list[go.Figure]:
    """Return gain, delay and coherence over frequency for small, middle and large swings; none where there are none."""
    measured = responses(found.recording, joint, found.recording.q_meas[:, joint])
    if not measured:
        return []
    twin = responses(found.recording, joint, found.predicted_joint("after", joint))
    name = found.recording.joint_names[joint]
    figures = []
    for key, y_title, factor in (
        ("gain", "gain", 1.0),
        ("delay_s", "delay, ms", 1e3),
        ("coherence", "coherence", 1.0),
    ):
        fig = figure("frequency, Hz", y_title, height=320, title=f"{name}: {y_title.split(',')[0]}")
        _draw(fig, measured, key, factor, dashed=False)
        if key != "coherence":
            _draw(fig, twin, key, factor, dashed=True)
        fig.update_yaxes(rangemode="tozero")
        fig.update_layout(showlegend=key == "gain", margin_t=90 if key == "gain" else 50, title_y=0.97)
        figures.append(fig)
    return figures


def _draw(fig: go.Figure, found: Sequence[Response], key: str, factor: float, *, dashed: bool) -> None:
    colours = _SIZES[-len(found) :]
    for one, colour in zip(found, colours, strict=True):
        plain = one.coherence > 0.5 if key != "coherence" else np.ones(len(one.frequency_hz), dtype=bool)
        fig.add_scatter(
            x=one.frequency_hz[plain],
            y=factor * getattr(one, key)[plain],
            mode="lines" if dashed else "lines+markers",
            name=f"±{np.degrees(np.sqrt(2.0) * one.swing_rad):.2g}°",
            line={"color": colour, "width": 1.5, "dash": "dot" if dashed else "solid"},
            marker={"size": 4},
            showlegend=not dashed,
        )


def step_responses(found: MotionDiagnosis, joint: int) -> go.Figure | None:
    """Return a joint's answers to single steps laid over one another, as shares of the step; None without steps."""
    steps = _steps(found, joint)
    if not steps:
        return None
    recording, twin = found.recording, found.predicted_joint("after", joint)
    title = f"{recording.joint_names[joint]}: {len(steps)} steps"
    fig = figure("time after the command, ms", "share of the step", height=320, title=title)
    for number, (row, size, end) in enumerate(steps):
        rows = np.arange(row, end)
        after = 1e3 * (recording.time_s[rows] - recording.time_s[row])
        for angles, colour, mode, name in (
            (recording.q_meas[:, joint], COLOURS["armtwin"], "markers", "measured"),
            (twin, COLOURS["extended"], "lines", "extended twin"),
        ):
            fig.add_scatter(
                x=after,
                y=(angles[rows] - angles[row]) / size,
                mode=mode,
                name=name,
                legendgroup=name,
                showlegend=number == 0,
                line={"color": colour, "width": 1},
                marker={"color": colour, "size": 4},
                hovertext=f"{np.degrees(size):+.1f}°",
            )
    fig.update_layout(margin_t=90, title_y=0.97)
    return fig


def _steps(found: MotionDiagnosis, joint: int) -> list[tuple[int, float, int]]:
    """Return row, size, rad, and end of a joint's largest steps that come out of rest and are left alone."""
    recording = found.recording
    sent, time = recording.q_cmd[:, joint], recording.time_s
    jumps = np.append(0.0, np.where(recording.first[1:], 0.0, np.diff(sent)))
    changed = np.flatnonzero(np.abs(jumps) > 1e-6)
    begins = np.flatnonzero(recording.first)
    out = []
    for row in changed[np.abs(jumps[changed]) > _STEP_RAD]:
        before, after = changed[changed < row], changed[changed > row]
        motion = int(np.searchsorted(begins, row, side="right"))
        last = int(begins[motion]) if motion < len(begins) else len(time)
        quiet = min(time[row] - (time[before[-1]] if len(before) else -np.inf), time[row] - time[begins[motion - 1]])
        end = int(np.searchsorted(time, time[row] + _SHOWN_S))
        end = min(end, last, int(after[0]) + 1 if len(after) else last)
        if (
            quiet > _QUIET_S
            and end < len(time)
            and time[end - 1] - time[row] > _QUIET_S
            and np.isfinite(recording.q_meas[row, joint])
        ):
            out.append((int(row), float(jumps[row]), end))
    return sorted(out, key=lambda one: -abs(one[1]))[:_MOST_STEPS]


def delay_by_correlation(found: MotionDiagnosis) -> go.Figure:
    """Return how alike the speeds of command and measurement are, over the delay between them, joint by joint."""
    fig = figure("delay of the measurement, ms", "correlation of the speeds", height=340)
    alike = likeness(found.recording)
    shown = (alike.lag_s > -0.1) & (alike.lag_s < 0.4)
    for joint, name in enumerate(found.recording.joint_names):
        if found.problem.moves(joint):
            curve = alike.correlation[joint, joint, shown]
            fig.add_scatter(x=1e3 * alike.lag_s[shown], y=curve, mode="lines", name=name)
    return fig
