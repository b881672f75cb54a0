"""Fitting a joint's loop together with the shape of its load over the pose.

An arm's masses, and where its model has its zeros, are seldom known well, and every motion has a remainder of its own
size: a chirp's fast end is not to drown what slow motions say of friction. So the load's amplitudes are fitted along,
and each motion is weighed by what the model leaves of it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from armtwin.calib.motion.fit import ZERO, with_values
from armtwin.calib.motion.series import Series, spread
from armtwin.models.catalogue.motion_effect import Slot
from armtwin.models.motion.loop import INDEX

Array = NDArray[np.float64]

# Shapes that the poses hardly tell from others are left out, as a share of the plainest.
_TOLD = 3e-3
# An amplitude's size that matters, rad, and a derivative's step in sizes.
_SCALE_RAD, _STEP = 0.002, 0.05
# Remainders beyond so many deviations of their motion lose their weight; a motion weighs as one of this share of all
# motions' deviation would at the most, and of this multiple at the least.
_REACH, _LEAST_SHARE, _MOST_SHARE = 4.0, 0.3, 2.0
# A constant part of the droop and the zero are one: of so small a share of the rows the zero is taken to be none.
_NO_ZERO = 0.0002
_ENOUGH = 3e-4


@dataclass(frozen=True, eq=False)
class Shape:
    """The shapes (N, k) that a joint's droop may have over the rows, rad for each of its k amplitudes."""

    columns: Array

    @classmethod
    def of(cls, basis: Array, rows: NDArray[np.bool_]) -> tuple[Shape, Array]:
        """Return the shapes that some rows can tell apart, and the (columns, k) matrix that makes them of a basis."""
        if not basis.shape[1]:
            return cls(basis), np.zeros((0, 0))
        _, sizes, axes = np.linalg.svd(basis[rows], full_matrices=False)
        plain = sizes > _TOLD * sizes[0]
        mix = (axes.T / sizes)[:, plain] * np.sqrt(rows.sum())
        return cls(basis @ mix), mix

    def amplitudes(self, wanted: Array, rows: NDArray[np.bool_]) -> Array:
        """(k,) amplitudes that come nearest to a droop (N,), rad, over some rows."""
        return np.asarray(self.columns[rows].T @ wanted[rows] / max(int(rows.sum()), 1))


@dataclass(frozen=True, eq=False)
class Shaped:
    """A loop's values, the amplitudes of its load's shapes, the remainder (N,), rad, and the loss by motions."""

    p: Array
    amplitudes: Array
    e: Array
    cost: float


def bearing(series: Series, shape: Shape, amplitudes: Array) -> Series:
    """Return a joint whose load is its droop, rad: with a droop of one a newton metre."""
    if not len(amplitudes):
        return series
    return replace(series, load_nm=np.ascontiguousarray(shape.columns @ amplitudes))


def fit_shaped(
    series: Series, shape: Shape, start: tuple[Array, Array], slots: Sequence[Slot], rounds: int = 12
) -> Shaped:
    """Fit slots and amplitudes from `start` by damped Gauss-Newton steps, every motion by the size of its remainder."""
    p, amplitudes = start[0].copy(), start[1].copy()
    if len(amplitudes):
        p[INDEX["droop_rad_nm"]] = 1.0
    slots = (ZERO, *slots)
    motion = np.cumsum(series.first, dtype=np.intp)

    def at(v: Array) -> tuple[Array, Array]:
        n = len(slots)
        values = [slot.scale * x for slot, x in zip(slots, v[:n], strict=True)]
        return with_values(p, slots, values), v[n:] * _SCALE_RAD

    def remainder(v: Array) -> Array:
        q, a = at(v)
        return bearing(series, shape, a).remainder(q)

    def clipped(v: Array) -> Array:
        q, a = at(v)
        return np.array([q[INDEX[s.slot]] / s.scale for s in slots] + list(a / _SCALE_RAD))

    v = clipped(np.array([p[INDEX[s.slot]] / s.scale for s in slots] + list(amplitudes / _SCALE_RAD)))
    e, damping = remainder(v), 1e-3
    for _ in range(rounds):
        reach = (_REACH * motion_scales(series, motion, e)) ** 2
        weight = 1.0 / (reach * (1.0 + e**2 / reach))
        prior = _NO_ZERO * float(weight[series.used].sum()) * ZERO.scale**2 if len(amplitudes) else 0.0
        cost = loss(series, e, reach) + prior * v[0] ** 2
        J = np.empty((len(e), len(v)))
        for k in range(len(v)):
            step = _STEP if k >= len(slots) or (v[k] + _STEP) * slots[k].scale < slots[k].bounds[1] else -_STEP
            moved = v.copy()
            moved[k] += step
            J[:, k] = (remainder(moved) - e) / step
        A, b = J.T @ (weight[:, None] * J), J.T @ (weight * e)
        A[0, 0] += prior
        b[0] += prior * v[0]
        ridge = np.diag(A) + 1e-9 * max(float(np.diag(A).max()), 1e-30)
        better = False
        for _ in range(5):
            trial = clipped(v - np.linalg.solve(A + np.diag(damping * ridge), b))
            e_trial = remainder(trial)
            cost_trial = loss(series, e_trial, reach) + prior * trial[0] ** 2
            if cost_trial < cost:
                better = True
                break
            damping = min(damping * 10.0, 1e6)
        if not better:
            break
        v, e, damping = trial, e_trial, max(damping / 5.0, 1e-6)
        if cost - cost_trial < _ENOUGH * cost:
            break
    reach = (_REACH * motion_scales(series, motion, e)) ** 2
    return Shaped(*at(v), e, loss(series, e, reach))


def motion_scales(series: Series, motion: NDArray[np.intp], e: Array) -> Array:
    """(N,) deviation of each row's motion, rad."""
    overall = max(spread(e[series.used]), series.grain_rad, 1e-6)
    out = np.full(len(e), overall)
    for number in np.unique(motion[series.used]):
        rows = series.used & (motion == number)
        own = min(max(spread(e[rows]), _LEAST_SHARE * overall), _MOST_SHARE * overall)
        out[motion == number] = max(own, series.grain_rad, 1e-6)
    return out


def loss(series: Series, e: Array, reach: Array) -> float:
    """Return Cauchy's loss over the rows that count, in squares of the motions' deviations."""
    used = series.used
    return float(np.log1p(e[used] ** 2 / reach[used]).sum())
