"""Fitting a joint's loop to its readings: damped Gauss-Newton with bounds, and a loss that gross errors do not bend."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armtwin.calib.motion.series import Series, spread
from armtwin.models.catalogue.motion_effect import Slot
from armtwin.models.motion.loop import INDEX

Array = NDArray[np.float64]

# The zero of a joint is its geometry: fitted along always.
ZERO = Slot("zero_rad", "zero_rad", (-1.0, 1.0), (0.0,), 0.002)

# No servo's loop is the nominal one to a percent, and no two simulations integrate it alike: so near to it, it is it.
NEARLY_NOMINAL = Slot("time_constant_s", "time_constant_s", (0.0185, 0.0215), (0.020,), 0.0005)

# Remainders beyond so many robust deviations lose their weight (Cauchy's loss).
_REACH = 4.0
# A derivative's step, in the size that matters of a parameter.
_STEP = 0.05
_ENOUGH = 1e-4


@dataclass(frozen=True, eq=False)
class Fit:
    """Values of the loop, the remainder (N,) that they leave, rad, and the robust cost, rad²."""

    p: Array
    e: Array
    cost: float


def with_values(p: Array, slots: Sequence[Slot], values: Sequence[float]) -> Array:
    """Return the loop's values with those of some slots, within their bounds."""
    out = p.copy()
    for slot, value in zip(slots, values, strict=True):
        out[INDEX[slot.slot]] = min(max(value, slot.bounds[0]), slot.bounds[1])
    return out


def robust_cost(e: Array, scale: float) -> float:
    """Return Cauchy's loss of a remainder, rad²."""
    reach = (_REACH * scale) ** 2
    return float(0.5 * reach * np.log1p(e**2 / reach).sum())


def robust_weight(e: Array, scale: float) -> Array:
    """(N,) weights that Cauchy's loss gives to the squares of a remainder."""
    return np.asarray(1.0 / (1.0 + (e / (_REACH * scale)) ** 2))


def scale_of(series: Series, e: Array, floor_rad: float) -> float:
    """Return the deviation about which a remainder is weighed: its own, never less than the noise."""
    return max(spread(e[series.used]), floor_rad, 1e-9)


def jacobian(series: Series, p: Array, e: Array, slots: Sequence[Slot]) -> Array:
    """(N, k) slopes of the remainder over slots, each in units of its scale."""
    J = np.empty((len(e), len(slots)))
    for column, slot in enumerate(slots):
        at = p[INDEX[slot.slot]]
        step = _STEP * slot.scale
        if at + step > slot.bounds[1]:
            step = -step
        moved = p.copy()
        moved[INDEX[slot.slot]] = at + step
        J[:, column] = (series.remainder(moved) - e) / (step / slot.scale)
    return J


def fit(series: Series, p: Array, slots: Sequence[Slot], floor_rad: float, rounds: int = 10) -> Fit:
    """Fit the smooth slots of a loop from `p`; scanned ones stay as they are."""
    free = [slot for slot in slots if not slot.scanned]
    e = series.remainder(p)
    scale = scale_of(series, e, floor_rad)
    cost = robust_cost(e, scale)
    damping = 1e-3
    for _ in range(rounds):
        J = jacobian(series, p, e, free)
        weight = robust_weight(e, scale)
        A = J.T @ (weight[:, None] * J)
        b = J.T @ (weight * e)
        ridge = np.diag(A) + 1e-12 * max(float(np.diag(A).max()), 1e-30)
        better = False
        for _ in range(5):
            step = -np.linalg.solve(A + np.diag(damping * ridge), b)
            values = [p[INDEX[s.slot]] + s.scale * d for s, d in zip(free, step, strict=True)]
            trial = with_values(p, free, values)
            e_trial = series.remainder(trial)
            cost_trial = robust_cost(e_trial, scale)
            if cost_trial < cost:
                better = True
                break
            damping = min(damping * 10.0, 1e6)
        if not better:
            break
        gained = (cost - cost_trial) / max(cost, 1e-300)
        p, e, cost = trial, e_trial, cost_trial
        damping = max(damping / 5.0, 1e-6)
        if gained < _ENOUGH:
            break
    return Fit(p, e, robust_cost(e, scale))
