"""A bus or a host that falls behind: from a moment on all joints answer later, or are read again and again."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armtwin.calib.motion.fit import robust_cost, scale_of
from armtwin.calib.motion.problem import MotionProblem
from armtwin.calib.motion.search import JointModel
from armtwin.models.motion.loop import INDEX

Array = NDArray[np.float64]

# The extra delay is estimated over stretches of this length, all joints together.
_STRETCH_S = 1.0
_FEWEST = 6
# A step of the delay shorter than this share of a row is none.
_LEAST_ROWS = 0.35
# It has to explain so much of the spread of the stretches' delays.
_PLAIN = 0.35
_JOINTS = 0.5
# Of the step a fit of one delay has given to the time before it.
_SHARES = (0.0, 0.25, 0.5, 0.75, 1.0)


@dataclass(frozen=True)
class Late:
    """From `from_s` to `until_s` every command is heard `late_s` later, by all joints."""

    from_s: float
    until_s: float
    late_s: float

    def put(self, p: Array) -> Array:
        """Return a loop's values with it."""
        out = p.copy()
        for slot, value in (("late_from_s", self.from_s), ("late_until_s", self.until_s), ("late_s", self.late_s)):
            out[INDEX[slot]] = value
        return out


def late(problem: MotionProblem, models: Sequence[JointModel]) -> Late | None:
    """Find from when on, and by how much, all joints answer later than the models say; None where they do not."""
    moving = [m for m in models if problem.moves(m.joint)]
    if not moving:
        return None
    times, delays, weights = _local_delays(problem, moving)
    if len(times) < _FEWEST:
        return None
    starts = _ends_of_motions(problem)
    best: tuple[float, Late] | None = None
    total = float((weights * (delays - np.average(delays, weights=weights)) ** 2).sum())
    for k in range(2, len(times) - 1):
        for until in {float("inf"), float(starts[np.searchsorted(starts, times[k])])}:
            inside = (times >= times[k]) & (times < until)
            if inside.sum() < 2 or (~inside).sum() < 2:
                continue
            high, low = (
                np.average(delays[inside], weights=weights[inside]),
                np.average(delays[~inside], weights=weights[~inside]),
            )
            left = float((weights * (delays - np.where(inside, high, low)) ** 2).sum())
            if best is None or left < best[0]:
                best = (left, Late(float(times[k] - _STRETCH_S / 2), until, float(high - low)))
    row_s = problem.series[0].row_s
    if best is None or best[0] > (1.0 - _PLAIN) * total or best[1].late_s < _LEAST_ROWS * row_s:
        return None
    return refined(problem, moving, best[1])


def _local_delays(problem: MotionProblem, models: Sequence[JointModel]) -> tuple[Array, Array, Array]:
    """(B,) middles of stretches, extra delays there, s, and their weights: where measured lags behind, e = delay · speed."""
    time = problem.series[0].time_s
    stretch = np.floor((time - time[0]) / _STRETCH_S).astype(int)
    top, bottom = np.zeros(stretch[-1] + 1), np.zeros(stretch[-1] + 1)
    for model in models:
        series = problem.series[model.joint]
        speed = np.gradient(model.fit.e + series.measured, time)
        usable = series.used & ~series.first & ~np.roll(series.first, -1) & (np.abs(speed) < 6.0)
        scale = scale_of(series, model.fit.e, model.noise_rad)
        np.add.at(top, stretch[usable], (model.fit.e * speed)[usable] / scale**2)
        np.add.at(bottom, stretch[usable], (speed**2)[usable] / scale**2)
    seen = bottom > 1e-3 * bottom.max()
    middles = time[0] + (np.arange(len(top)) + 0.5) * _STRETCH_S
    return middles[seen], top[seen] / bottom[seen], bottom[seen]


def _ends_of_motions(problem: MotionProblem) -> Array:
    recording = problem.recording
    begins = recording.time_s[recording.first]
    return np.append(begins[1:], np.inf)


def _cost(problem: MotionProblem, models: Sequence[JointModel], found: Late, delays: dict[int, float]) -> float:
    """Return the loss of all joints, each in units of its own remainder."""
    out = 0.0
    for model in models:
        series = problem.series[model.joint]
        p = found.put(model.fit.p)
        p[INDEX["delay_s"]] = delays[model.joint]
        scale = scale_of(series, model.fit.e, model.noise_rad)
        out += robust_cost(series.remainder(p)[series.used], scale) / scale**2
    return out


def refined(problem: MotionProblem, models: Sequence[JointModel], rough: Late) -> Late | None:
    """Move the moment row by row and fit its size; each joint's own delay gives back what the step took."""
    row_s = problem.series[0].row_s
    best, cost = rough, np.inf
    lowered = {m.joint: float(m.fit.p[INDEX["delay_s"]]) for m in models}
    before = _cost(problem, models, Late(np.inf, np.inf, 0.0), lowered)
    moment, size = rough.from_s, rough.late_s
    for reach, count, by in ((2.0, 17, 0.2), (0.4, 17, 0.06), (3 * row_s, 7, 0.02), (0.0, 1, 0.01), (0.0, 1, 0.003)):
        for at in moment + np.linspace(-reach, reach, count):
            for much in size * (1.0 + by * np.array([-1.0, -0.5, 0.0, 0.5, 1.0])):
                for share in _SHARES:
                    delays = {j: max(0.0, d - share * much) for j, d in lowered.items()}
                    trial = Late(float(at), rough.until_s, float(much))
                    c = _cost(problem, models, trial, delays)
                    if c < cost:
                        best, cost = trial, c
        moment, size = best.from_s, best.late_s
    if cost > before - 50.0:
        return None
    return best if _most_joints_gain(problem, models, best) else None


def _most_joints_gain(problem: MotionProblem, models: Sequence[JointModel], found: Late) -> bool:
    gains = []
    for model in models:
        own = {model.joint: float(model.fit.p[INDEX["delay_s"]])}
        without = _cost(problem, [model], Late(np.inf, np.inf, 0.0), own)
        lower = [{model.joint: max(0.0, own[model.joint] - share * found.late_s)} for share in _SHARES]
        with_it = min(_cost(problem, [model], found, delays) for delays in lower)
        gains.append(with_it < without)
    return len(gains) == 1 or float(np.mean(gains)) > _JOINTS
