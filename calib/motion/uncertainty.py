"""Standard deviations of a joint's values, from whole blocks of rows that are longer than the remainder's memory.

The sandwich of Huber and White with blocks in the middle (clusters): it needs neither independent rows nor a right
model, only blocks that know nothing of one another.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from armtwin.calib.motion.fit import jacobian, robust_cost, robust_weight, scale_of, with_values
from armtwin.calib.motion.joint_model import JointModel
from armtwin.calib.motion.series import Series, memory_rows
from armtwin.models.catalogue.motion_effect import Slot
from armtwin.models.motion.loop import INDEX

Array = NDArray[np.float64]

_BLOCK_MEMORIES = 4
_LEAST_BLOCK = 10
# With fewer independent pieces an interval would be a guess.
_FEWEST_BLOCKS = 12
# Thresholds: the values within which the loss stays this near to its least, two standard deviations of a Gaussian.
_NEAR = 2.0
_SHARES = np.array([2e-4, 5e-4, 1e-3, 2e-3, 5e-3, 1e-2, 2e-2, 5e-2, 0.1, 0.2])


def deviations(series: Series, model: JointModel) -> dict[str, float | None]:
    """Return the standard deviation of each fitted slot by its name, in its unit; None where it cannot be said."""
    smooth = [slot for slot in model.slots if not slot.scanned]
    e, used = model.fit.e, series.used
    scale = scale_of(series, e, model.noise_rad)
    weight = robust_weight(e, scale)
    J = jacobian(series, model.fit.p, e, smooth)
    rows = np.flatnonzero(used)
    length = max(_LEAST_BLOCK, _BLOCK_MEMORIES * memory_rows(e[used]))
    block = np.arange(len(rows)) // length
    n_blocks = int(block[-1]) + 1 if len(rows) else 0
    out: dict[str, float | None] = {slot.slot: None for slot in model.slots}
    if n_blocks < _FEWEST_BLOCKS:
        return out
    H = J[rows].T @ (weight[rows, None] * J[rows])
    scores = np.zeros((n_blocks, len(smooth)))
    np.add.at(scores, block, (weight * e)[rows, None] * J[rows])
    free = np.diag(H) > 1e-9 * np.diag(H).max()
    inverse = np.linalg.pinv(H[np.ix_(free, free)])
    middle = scores[:, free].T @ scores[:, free] * n_blocks / max(n_blocks - free.sum(), 1)
    covariance = inverse @ middle @ inverse
    named = [slot for slot, is_free in zip(smooth, free, strict=True) if is_free]
    for slot, variance in zip(named, np.diag(covariance), strict=True):
        out[slot.slot] = float(np.sqrt(max(variance, 0.0)) * slot.scale)
    worth = max(1.0, len(rows) / memory_rows(e[used]))
    for slot in model.slots:
        if slot.scanned:
            out[slot.slot] = _of_threshold(series, model, slot, scale, worth / max(len(rows), 1))
    return out


def _of_threshold(series: Series, model: JointModel, slot: Slot, scale: float, per_row: float) -> float | None:
    """Return half the range over which a threshold's loss stays near to its least, as one deviation."""
    at = model.fit.p[INDEX[slot.slot]]
    is_moment = slot.slot.endswith("_s")
    steps = np.arange(1, 11) * series.row_s if is_moment else _SHARES * (abs(at) or 1e-3)
    least = robust_cost(series.remainder(model.fit.p), scale)
    ends = []
    for side in (-1.0, 1.0):
        reach = float(steps[0])
        for step in steps:
            e = series.remainder(with_values(model.fit.p, [slot], [at + side * step]))
            if (robust_cost(e, scale) - least) / scale**2 * per_row > _NEAR:
                break
            reach = float(step)
        ends.append(reach)
    return float(sum(ends) / 4.0)
