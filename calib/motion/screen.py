"""A first look at every candidate: one linear step with all that is fitted, without a fit of its own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armtwin.calib.motion.candidates import Start
from armtwin.calib.motion.fit import jacobian, robust_weight, with_values
from armtwin.calib.motion.series import Series
from armtwin.models.catalogue.motion_effect import Slot
from armtwin.models.motion.loop import INDEX, NEUTRAL

Array = NDArray[np.float64]

# Linear slots are tried with so much of the size that matters.
_TRIED = 1.0


@dataclass(frozen=True, eq=False)
class Promise:
    """A candidate with the values to begin at, and the sum of squares that one step leaves, rad²."""

    start: Start
    p: Array
    left: float


def promises(
    series: Series, p: Array, e: Array, free: Sequence[Slot], tried: Sequence[Start], scale: float
) -> list[Promise]:
    """Rank candidates by what one step with all free slots leaves of the remainder, the most promising first."""
    weight = np.sqrt(robust_weight(e, scale))
    smooth = [slot for slot in free if not slot.scanned]
    J = jacobian(series, p, e, smooth) * weight[:, None]
    Q, _ = np.linalg.qr(J)
    base = weight * e
    base = base - Q @ (Q.T @ base)
    out = [_promise(series, p, e, start, weight, Q, base) for start in tried]
    return sorted(out, key=lambda promise: promise.left)


def _promise(series: Series, p: Array, e: Array, start: Start, weight: Array, Q: Array, base: Array) -> Promise:
    slots = start.form.slots
    linear = [slot for slot, value in zip(slots, start.values, strict=True) if value is None]
    fixed = [(slot, value) for slot, value in zip(slots, start.values, strict=True) if value is not None]
    at = with_values(p, [slot for slot, _ in fixed], [value for _, value in fixed])
    columns = []
    if not linear:
        columns.append(series.remainder(at) - e)
    for slot in linear:
        moved = at.copy()
        moved[INDEX[slot.slot]] = NEUTRAL[slot.slot] + _TRIED * slot.scale
        columns.append(series.remainder(moved) - e)
    D = np.stack(columns, axis=1) * weight[:, None]
    D = D - Q @ (Q.T @ D)
    gram = D.T @ D + 1e-30 * np.eye(len(columns))
    share = -np.linalg.solve(gram, D.T @ base)
    if not linear:
        share = np.clip(share, 0.0, 3.0)
    left = base + D @ share
    if linear:
        at = with_values(
            at, linear, [NEUTRAL[s.slot] + _TRIED * s.scale * a for s, a in zip(linear, share, strict=True)]
        )
    return Promise(start, at, float(left @ left))
