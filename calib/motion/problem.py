"""A moving recording made ready: what is fitted, what is held out, each joint's readings with their grain."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from armtwin.calib.motion.series import Series
from armtwin.models.errors import RecordingError
from armtwin.models.motion.headings import Headings, headings_of
from armtwin.models.motion.loads import gravity_torques
from armtwin.models.recordings.moving import MovingRecording

Array = NDArray[np.float64]

# Share of the rows that is kept back where the recording names no motion for it, and of a single motion.
_HELD_SHARE = 0.25
_LEAST_MOTIONS = 3
# Joints whose command moves less than this are not moved by it.
_STILL_RAD = 1e-3
_LEAST_ROWS = 60
_LEAST_READINGS = 30
# Files give five decimals, often.
_PRINTED_RAD = 1e-5
# A lattice is seen in so many different readings.
_LEAST_STEPS = 3


@dataclass(frozen=True, eq=False)
class MotionProblem:
    """All that the search looks at.

    Attributes:
        recording: as it was read.
        loads_nm: (N, n) gravity's torques, zero where they are not known.
        has_load: whether they are known and vary.
        fitted, held: (N,) rows.
        series: each joint over the fitted rows.
        grains_rad: (n,) steps of the readings.
        headings: what the loads follow, or None.

    """

    recording: MovingRecording
    loads_nm: Array
    has_load: bool
    fitted: NDArray[np.bool_]
    held: NDArray[np.bool_]
    series: tuple[Series, ...]
    grains_rad: Array
    headings: Headings | None = None

    @property
    def angles(self) -> Array:
        """(N, n) measured angles, rad, the command where one is missing."""
        return angles_of(self.recording, 0.0)

    @property
    def held_motions(self) -> tuple[str, ...]:
        """Names of the motions that are held out, wholly or in part."""
        return tuple(name for name in self.recording.motions if self.held[self.recording.rows_of(name)].any())

    def moves(self, joint: int) -> bool:
        """Whether a joint (from 0) is sent somewhere in the fitted rows, and seen to go."""
        series = self.series[joint]
        return self.is_read(joint) and bool(np.ptp(series.sent[series.used]) > _STILL_RAD)

    def is_read(self, joint: int) -> bool:
        """Whether a joint's readings are enough to tell something, and not stuck at one angle."""
        series = self.series[joint]
        read = series.measured[series.used]
        return len(read) >= _LEAST_READINGS and bool(np.ptp(read) > 0.0)

    def whole(self, joint: int, motion: str) -> Series:
        """Return a joint with one motion alone, all of whose rows count."""
        rows = np.zeros(len(self.recording), dtype=bool)
        rows[self.recording.rows_of(motion)] = True
        series = self.series[joint]
        return replace(series, wanted=rows, used=rows & np.isfinite(self.recording.q_meas[:, joint]))


def motion_problem(recording: MovingRecording) -> MotionProblem:
    """Prepare a recording; raises `RecordingError` where an arm's model does not load or nothing can be fitted."""
    angles = angles_of(recording, 0.0)
    torques = gravity_torques(recording.arm, angles)
    loads = np.zeros_like(recording.q_cmd) if torques is None else torques
    held = _held(recording)
    fitted = ~held
    if fitted.sum() < _LEAST_ROWS:
        raise RecordingError(
            f"samples.csv: {int(fitted.sum())} rows are left to fit beside what is held out; {_LEAST_ROWS} are wanted"
        )
    steps = grains(recording.q_meas)
    series = tuple(_series(recording, loads, fitted, j, float(steps[j])) for j in range(recording.n_joints))
    headings = None if torques is None else headings_of(angles, torques)
    return MotionProblem(recording, loads, torques is not None, fitted, held, series, steps, headings)


def angles_of(recording: MovingRecording, zeros_rad: Array | float) -> Array:
    """(N, n) angles that the readings mean, less the joints' zeros; what is missing is interpolated."""
    return np.stack([_filled(recording.time_s, column) for column in recording.q_meas.T], axis=-1) - zeros_rad


def at_zeros(problem: MotionProblem, zeros_rad: Array) -> MotionProblem:
    """Return the problem with the loads at the angles that the readings mean, less the joints' zeros (n,), rad."""
    if not problem.has_load:
        return problem
    loads = gravity_torques(problem.recording.arm, angles_of(problem.recording, zeros_rad))
    assert loads is not None
    series = tuple(
        replace(one, load_nm=np.ascontiguousarray(loads[:, joint])) for joint, one in enumerate(problem.series)
    )
    return replace(problem, loads_nm=loads, series=series)


def grains(q_meas: Array) -> Array:
    """(n,) steps of the readings (N, n); a joint whose few readings fit another's step has the same encoder."""
    found = np.array([grain(column) for column in q_meas.T])
    if found.any():
        usual = float(np.median(found[found > 0.0]))
        for joint, column in enumerate(q_meas.T):
            if found[joint] == 0.0 and _fits(np.unique(column[np.isfinite(column)]), usual):
                found[joint] = usual
    return found


def grain(measured: Array) -> float:
    """Return the step of which all readings are multiples about an origin, or 0 where there is none."""
    values = np.unique(measured[np.isfinite(measured)])
    gaps = np.diff(values)
    gaps = gaps[gaps > 2 * _PRINTED_RAD]
    if len(gaps) < _LEAST_STEPS or len(values) > 0.9 * np.isfinite(measured).sum():
        return 0.0
    step = float(np.median(gaps[gaps < 1.5 * gaps.min() + _PRINTED_RAD]))
    reach = 8.0
    while True:  # the step is the better known the further it was counted
        near = values[values - values[0] <= reach * step] - values[0]
        count = np.round(near / step)
        if count.any():
            step = float((near @ count) / (count @ count))
        if len(near) == len(values):
            return step if _fits(values, step) else 0.0
        reach *= 2.0


def _fits(values: Array, step: float) -> bool:
    if len(values) == 0 or step < 4 * _PRINTED_RAD:
        return False
    over = values - values[0]
    off = np.abs(over - np.round(over / step) * step)
    return bool(np.quantile(off, 0.99) < max(0.1 * step, 2 * _PRINTED_RAD))


def _held(recording: MovingRecording) -> NDArray[np.bool_]:
    """Return the rows that are kept back: named motions, else a quarter of the motions, or the last of each."""
    held = np.isin(recording.trajectory, recording.held_out)
    if recording.held_out:
        return held
    motions = recording.motions
    if len(motions) >= _LEAST_MOTIONS:
        n = max(1, round(_HELD_SHARE * len(motions)))
        return np.isin(recording.trajectory, motions[1 :: max(1, len(motions) // n)][:n])
    for name in motions:
        rows = recording.rows_of(name)
        held[rows[round((1.0 - _HELD_SHARE) * len(rows)) :]] = True
    return held


def _series(
    recording: MovingRecording, loads: Array, fitted: NDArray[np.bool_], joint: int, grain_rad: float
) -> Series:
    measured = recording.q_meas[:, joint]
    seen = np.isfinite(measured)
    filled = _filled(recording.time_s, measured)
    # A motion whose first reading is missing begins where the last one was sent.
    blind = np.flatnonzero(recording.first & ~seen)
    sent = recording.q_cmd[:, joint]
    filled[blind] = sent[np.maximum(blind - 1, 0)] + np.nanmedian(measured - sent)
    wanted = np.isin(recording.trajectory, np.unique(recording.trajectory[fitted]))
    given = recording.time_s if recording.commanded_s is None else recording.commanded_s
    return Series(
        time_s=recording.time_s,
        given_s=np.maximum.accumulate(np.where(np.isfinite(given), given, recording.time_s)),
        sent=np.ascontiguousarray(sent),
        load_nm=np.ascontiguousarray(loads[:, joint]),
        measured=filled,
        first=recording.first,
        wanted=wanted,
        used=seen & fitted,
        grain_rad=grain_rad,
    )


def _filled(time_s: Array, measured: Array) -> Array:
    seen = np.isfinite(measured)
    return np.array(np.interp(time_s, time_s[seen], measured[seen]))
