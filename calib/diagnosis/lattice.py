"""Commands that lie on a coarse lattice: whole degrees, or pulse widths read in coarse steps.

Where a joint's commands were read off a scale, or rounded before they were written down, nearly all of them are whole
multiples of one step away from one another. That is seen in the commands alone, and it bounds what any diagnosis can
find: a command read in steps is off by up to half a step, whatever the arm does.

An evenly planned sweep also has one step from each pose to the next, and no holes: that is a plan, not a scale. On a
scale the poses lie at uneven numbers of steps.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import gcd

import numpy as np
from numpy.typing import NDArray
from scipy import stats

Array = NDArray[np.float64]

# Poses closer than this are the same number, written with six digits or computed twice.
_SAME_RAD = 3e-6
# 0.03 degrees, a third of what a 12-bit encoder tells: finer steps limit nobody.
_LEAST_STEP_RAD = 5e-4
# Of the shortest gaps between poses this many are tried, each as up to so many steps.
_GAPS = 40
_MOST_STEPS = 12
# On the lattice is what is off by no more than a rounded digit, or this share of the step.
_OFF_SHARE = 0.01
# A few values may have been read more finely than the rest.
_LEAST_SHARE = 0.8
# Chance that poses anywhere would lie so close to one of the lattices that are tried.
_CHANCE = 1e-6


@dataclass(frozen=True)
class Lattice:
    """Steps of `step_rad` on which `on_lattice` of the `poses` distinct commands of a `joint` (from 1) lie."""

    joint: int
    step_rad: float
    on_lattice: int
    poses: int

    @property
    def reading_std_rad(self) -> float:
        """Standard deviation of a value that may lie anywhere within its step."""
        return self.step_rad / float(np.sqrt(12.0))


def command_lattices(q_cmd: Array) -> list[Lattice]:
    """Return the coarse lattices of (N, n) commands, rad, joint by joint; most recordings have none."""
    found = []
    for joint in range(q_cmd.shape[1]):
        step, members = coarse_step(q_cmd[:, joint])
        if step > 0:
            found.append(Lattice(joint + 1, step, int(members.sum()), len(members)))
    return found


def coarse_step(
    angles: Array, least_step_rad: float = _LEAST_STEP_RAD, off_share: float = _OFF_SHARE
) -> tuple[float, NDArray[np.bool_]]:
    """Return the largest step on which (N,) angles lie unevenly, or 0, and which distinct ones, ascending, do.

    On it is what is off by no more than `off_share` of the step.
    """
    values = _distinct(angles)
    gaps = np.unique(np.diff(values))[:_GAPS]
    steps = (gaps[:, None] / np.arange(1, _MOST_STEPS + 1)).ravel() if len(values) > 4 else np.zeros(0)
    for step in -np.sort(-steps[steps > least_step_rad]):
        refined, members = _members(values, float(step), off_share)
        enough = members.mean() >= _LEAST_SHARE and _beyond_chance(members, refined, len(steps), off_share)
        if enough and _uneven(angles, values[members], refined):
            return refined, members
    return 0.0, np.zeros(len(values), dtype=bool)


def _members(values: Array, step: float, off_share: float) -> tuple[float, NDArray[np.bool_]]:
    """Return the step, refined, and the values on its lattice, whose origin lies where most of them agree."""
    # The step is known to a rounded digit only: over many steps that adds up, so the fit grows from near to far.
    origin = _densest(np.mod(values, step), step, _allowed(step, off_share) * step)
    for slack in (0.1, 0.03, _allowed(step, off_share)):
        counts = np.round((values - origin) / step)
        members = np.abs(values - origin - counts * step) <= slack * step
        if members.sum() < 3 or np.ptp(counts[members]) == 0:
            break
        step, origin = (float(x) for x in np.polyfit(counts[members], values[members], 1))
    off = np.abs(values - origin - np.round((values - origin) / step) * step)
    return step, off <= _allowed(step, off_share) * step


def _allowed(step: float, off_share: float) -> float:
    return max(_SAME_RAD / step, off_share)


def _densest(phases: Array, step: float, reach: float) -> float:
    """Return the phase that most phases lie within `reach` of, round the circle of one step."""
    apart = np.abs(phases[:, None] - phases)
    return float(phases[np.argmax((np.minimum(apart, step - apart) <= reach).sum(axis=1))])


def _beyond_chance(members: NDArray[np.bool_], step: float, tried: int, off_share: float) -> bool:
    """Whether values anywhere would hardly lie so: two fix the lattice, each other meets it by chance."""
    n, on = len(members), int(members.sum())
    return bool(tried * n * stats.binom.sf(on - 3, n - 2, 2.0 * _allowed(step, off_share)) < _CHANCE)


def _uneven(angles: Array, values: Array, step: float) -> bool:
    """Whether the poses leave uneven holes on the lattice, or are visited in uneven strides, as no even sweep does."""
    holes = np.round(np.diff(values) / step).astype(int).tolist()
    strides = np.abs(np.round(np.diff(angles) / step)).astype(int)
    # An even sweep strides by one step, or jumps to where the next one begins.
    return gcd(*holes) == 1 and (len(set(holes)) > 1 or len(np.unique(strides[strides > 0])) > 2)


def _distinct(values: Array) -> Array:
    ordered = np.sort(values)
    return ordered[np.concatenate([[True], np.diff(ordered) > _SAME_RAD])]
