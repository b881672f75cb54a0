"""A bus or a host that falls behind: from a moment on all joints answer later, or are read again and again."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from armtwin.calib.motion.fit import NEARLY_NOMINAL, ZERO, fit, robust_cost, scale_of, with_values
from armtwin.calib.motion.joint_model import JointModel
from armtwin.calib.motion.problem import MotionProblem
from armtwin.calib.motion.series import Series
from armtwin.models.catalogue.motion_effect import Slot
from armtwin.models.motion.loop import INDEX, NEUTRAL

Array = NDArray[np.float64]

# The extra delay is estimated over stretches of this length, all joints together.
_STRETCH_S = 1.0
_FEWEST = 6
# A step of the delay shorter than this share of a row is none.
_LEAST_ROWS = 0.35
# It has to explain so much of the spread of the stretches' delays.
_PLAIN = 0.35
_JOINTS = 0.5
# And win so much of the loss.
_PLAINLY = 50.0
# Without a delay before the step the loss may be this times the loss with one.
_NO_WORSE = 1.02
_DELAY = Slot("delay_s", "delay_s", (0.0, 0.5), (0.0,), 0.005)
_SIZE = Slot("delay_s", "late_s", (0.0, 0.5), (0.0,), 0.005)
# Moments that are tried over a whole log, and sizes of the step in those that were seen.
_MOST_MOMENTS, _SIZES = 30, (1.0, 1.6, 2.5)
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

    def off(self, p: Array) -> Array:
        """Return a loop's values without it."""
        return replace(self, from_s=np.inf, late_s=0.0).put(p)


def late(problem: MotionProblem, models: Sequence[JointModel], *, within: bool = False) -> Late | None:
    """Find from when on, and by how much, all joints answer later than the models say; None where they do not.

    To the end of the log, or only `within` a motion: that is asked of models that know the arm's friction and lag,
    which differ from motion to motion as delays do.
    """
    moving = [m for m in models if problem.moves(m.joint)]
    if not moving:
        return None
    times, delays, weights = _local_delays(problem, moving)
    if len(times) < _FEWEST:
        return None
    spans = _motions(problem) if within else [(-np.inf, np.inf)]
    row_s = problem.series[0].row_s
    for begin, end in spans:
        inside = (times > begin) & (times < end)
        found = _step(times[inside], delays[inside], weights[inside], end)
        if found is not None and found.late_s > _LEAST_ROWS * row_s:
            if not within:
                found = _roughly(problem, moving, found, times)
            found = refined(problem, moving, found)
            if found is not None:
                return found
    return None


def _step(times: Array, delays: Array, weights: Array, until: float) -> Late | None:
    """Return the moment at which the delay plainly rises, and by how much, or None."""
    if len(times) < _FEWEST:
        return None
    total = float((weights * (delays - np.average(delays, weights=weights)) ** 2).sum())
    best: tuple[float, Late] | None = None
    for k in range(2, len(times) - 1):
        low, high = np.average(delays[:k], weights=weights[:k]), np.average(delays[k:], weights=weights[k:])
        left = float((weights * (delays - np.where(np.arange(len(times)) < k, low, high)) ** 2).sum())
        if best is None or left < best[0]:
            best = (left, Late(float(times[k] - _STRETCH_S / 2), float(until), float(high - low)))
    return best[1] if best is not None and best[0] < (1.0 - _PLAIN) * total else None


def _roughly(problem: MotionProblem, models: Sequence[JointModel], seen: Late, times: Array) -> Late:
    """Ask all motions: where the arm answers sooner than it is late, a stretch's delay comes out too small."""
    begins = [begin for begin, _ in _motions(problem)]
    moments = [seen.from_s, *times[:: max(1, len(times) // _MOST_MOMENTS)], *begins[1:]]
    trials = [Late(float(at), seen.until_s, size * seen.late_s) for at in moments for size in _SIZES]
    pairs = [(problem.series[m.joint], m) for m in models]
    return min(trials, key=lambda trial: sum(_cost(series, m, trial, _own(m)) for series, m in pairs))


def _local_delays(problem: MotionProblem, models: Sequence[JointModel]) -> tuple[Array, Array, Array]:
    """(B,) middles of stretches, extra delays there, s, and their weights: what lags has e = delay · speed."""
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


def _motions(problem: MotionProblem) -> list[tuple[float, float]]:
    """List when each motion begins and ends, s."""
    recording = problem.recording
    begins = recording.time_s[recording.first]
    ends = np.append(begins[1:], recording.time_s[-1] + 1.0)
    return [(float(a), float(b)) for a, b in zip(begins, ends, strict=True)]


def touched(problem: MotionProblem, models: Sequence[JointModel], found: Late) -> list[Series]:
    """Return each joint's series with the motions alone that a step may change."""
    out = []
    for model in models:
        series = problem.series[model.joint]
        number = np.cumsum(series.first)
        inside = (series.time_s > found.from_s - 2.5) & (series.time_s < found.until_s)
        rows = np.isin(number, np.unique(number[inside])) & series.wanted
        out.append(replace(series, wanted=rows, used=series.used & rows))
    return out


def _cost(series: Series, model: JointModel, found: Late, delay_s: float) -> float:
    """Return the loss of a joint in units of its whole remainder: a late stretch is no gross error."""
    p = found.put(model.fit.p)
    p[INDEX["delay_s"]] = delay_s
    e = model.fit.e[series.used]
    scale = max(float(np.sqrt(np.mean(e**2))) if len(e) else 0.0, model.noise_rad)
    return robust_cost(series.remainder(p)[series.used], scale) / scale**2


def refined(problem: MotionProblem, models: Sequence[JointModel], rough: Late) -> Late | None:
    """Move the moment row by row and fit its size; each joint's own delay gives back what the step took."""
    row_s = problem.series[0].row_s
    asked = list(zip(touched(problem, models, rough), models, strict=True))
    shares = _SHARES if np.isinf(rough.until_s) else (0.0,)
    none = Late(np.inf, np.inf, 0.0)
    before = sum(_cost(s, m, none, _own(m)) for s, m in asked)
    best, cost = rough, np.inf
    moment, size = rough.from_s, rough.late_s
    for reach, count, by in ((2.0, 9, 0.5), (0.5, 9, 0.2), (3 * row_s, 7, 0.06), (0.0, 1, 0.02), (0.0, 1, 0.006)):
        for at in moment + np.linspace(-reach, reach, count):
            for much in size * (1.0 + by * np.array([-1.0, -0.5, 0.0, 0.5, 1.0])):
                trial = Late(float(at), rough.until_s, float(much))
                c = min(sum(_cost(s, m, trial, max(0.0, _own(m) - share * much)) for s, m in asked) for share in shares)
                if c < cost:
                    best, cost = trial, c
        moment, size = best.from_s, best.late_s
    best = _with_size(problem, models, best)
    if cost > before - _PLAINLY:
        return None
    gains = []
    for series, model in asked:
        delays = [max(0.0, _own(model) - share * best.late_s) for share in _SHARES]
        gains.append(min(_cost(series, model, best, d) for d in delays) < _cost(series, model, none, _own(model)))
    return best if len(gains) == 1 or float(np.mean(gains)) > _JOINTS else None


def _own(model: JointModel) -> float:
    return float(model.fit.p[INDEX["delay_s"]])


def _with_size(problem: MotionProblem, models: Sequence[JointModel], found: Late) -> Late:
    """Fit the size at every joint, beside its own delay or without one; what most of them say is taken."""
    sizes: dict[bool, list[float]] = {True: [], False: []}
    costs = {True: 0.0, False: 0.0}
    for model in models:
        series = problem.series[model.joint]
        scale = scale_of(series, model.fit.e, model.noise_rad)
        for with_delay in (True, False):
            own = [max(0.0, _own(model) - share * found.late_s) for share in _SHARES] if with_delay else [0.0]
            # A time constant that has made up for a part of the delay is asked anew.
            nominal = [slot for slot in model.slots if slot is NEARLY_NOMINAL]
            at = with_values(model.fit.p, nominal, [NEUTRAL[slot.slot] for slot in nominal])
            starts = [found.put(with_values(at, [_DELAY], [delay])) for delay in own]
            p = min(starts, key=lambda one: robust_cost(series.remainder(one), scale))
            slots = (ZERO, *nominal, _DELAY, _SIZE) if with_delay else (ZERO, *nominal, _SIZE)
            fitted = fit(series, p, slots, model.noise_rad)
            sizes[with_delay].append(float(fitted.p[INDEX["late_s"]]))
            costs[with_delay] += robust_cost(fitted.e, scale) / scale**2
    delayed = costs[False] > _NO_WORSE * costs[True]
    return replace(found, late_s=float(np.median(sizes[delayed])))
