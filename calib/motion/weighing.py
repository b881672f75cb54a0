"""Whether what a form takes away of a joint's remainder makes it a cause."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from armtwin.calib.motion.joint_model import JointModel, noise_of
from armtwin.calib.motion.problem import MotionProblem
from armtwin.calib.motion.series import Series, spread

Array = NDArray[np.float64]

# Level of the family of all effects at all joints: one false alarm in a thousand logs.
LEVEL = 1e-3
# A motion of so many rows is asked; what some lose may be so much of what others gain.
_A_MOTION, _WORSE = 100, 0.15
# A cause that takes away less than this of the remainder's innovations matters to nobody, whatever its significance;
# and one that takes less than this of what the remainder has beyond the noise is the imperfect form of the others.
_LEAST_SHARE = 0.004
_OF_THE_EXCESS = 0.08
# What moves the angles by less than so much of the readings' step (rounding has 0.29 of one), or of their noise, is no
# cause: rounding is no chance, and no twin is exact.
_OF_A_STEP, _OF_THE_NOISE = 0.35, 0.6
# Of two forms the one with fewer numbers is taken where it leaves no more than this beyond the other's.
AS_GOOD = 8.0


def threshold(n_slots: int, n_tried: int) -> float:
    """Return the deviance that a form of so many numbers must win where so many forms were tried."""
    return float(chi2.isf(LEVEL / max(n_tried, 1), n_slots))


def _tried(problem: MotionProblem) -> int:
    """Count what is tried: some thirty forms at each joint."""
    return 30 * problem.recording.n_joints


def weighs(
    problem: MotionProblem, series: Series, before: Array, after: Array, n_slots: int, *, new: bool = True
) -> bool:
    """Whether what `after` has beyond `before` is a cause; what stands already is asked less than what is `new`."""
    used = series.used
    moved = float(np.sqrt(np.mean((before - after)[used] ** 2)))
    if moved < max(_OF_A_STEP * series.grain_rad, _OF_THE_NOISE * noise_of(series, after)):
        return False
    least = used.sum() * noise_of(series, after) ** 2
    plain = float((before[used] ** 2).sum()), float((after[used] ** 2).sum())  # what stops an arm shows as gross errors
    capped = _squares(before[used]), _squares(after[used])
    if all(old - left < _OF_THE_EXCESS * (old - least) for old, left in (plain, capped)):
        return False
    if new and not _holds_in_all_motions(problem, used, before, after):
        return False
    gain = series.gain(before, after)
    return gain > max(threshold(n_slots, _tried(problem)), _LEAST_SHARE * used.sum())


def _holds_in_all_motions(problem: MotionProblem, used: NDArray[np.bool_], before: Array, after: Array) -> bool:
    """Whether no motion is followed plainly worse: a delay, a lag or a friction is one number over all of them."""
    changes: list[float] = []
    for motion in problem.recording.motions:
        rows = problem.recording.rows_of(motion)
        rows = rows[used[rows]]
        if len(rows) >= _A_MOTION:
            changes.append(_squares(after[rows]) - _squares(before[rows]))
    worse, better = sum(c for c in changes if c > 0.0), -sum(c for c in changes if c < 0.0)
    return worse <= _WORSE * better


def _squares(e: Array) -> float:
    """Return the sum of squares, in which no reading counts for more than six deviations."""
    return float((np.minimum(np.abs(e), 6.0 * max(spread(e), 1e-12)) ** 2).sum())


def better(series: Series, one: JointModel, other: JointModel) -> bool:
    """Whether one model explains the readings better than another; each number costs its share."""
    used = series.used
    gain = series.gain(other.fit.e, one.fit.e)
    extra = len(one.forms[-1].slots) - len(other.forms[-1].slots)
    memory = (
        0.5
        * used.sum()
        * np.log(max(float(np.mean(other.fit.e[used] ** 2)), 1e-30) / max(float(np.mean(one.fit.e[used] ** 2)), 1e-30))
    )
    return gain + memory > AS_GOOD * extra
