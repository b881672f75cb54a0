"""The gain where poses are few: every pose is predicted by a model that was fitted to others.

Keeping a quarter of a dozen poses back costs the search the power to find anything. All are searched then, and the
parameters of what was found are fitted again without each fold in turn: its form has seen every pose, no number has.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from armtwin.calib.diagnosis.explanation import Explanation
from armtwin.calib.diagnosis.fit import Data, fit

Array = NDArray[np.float64]
Bool = NDArray[np.bool_]

# With fewer poses than this none is kept back.
FEW_POSES = 20
_FOLDS = 4
LEFT_IN = 1.0 - 1.0 / _FOLDS


def crossed_predictions(data: Data, explanation: Explanation) -> tuple[Array, Array]:
    """(N, M, d) predictions of the calibrated and of the extended twin, each pose's from the folds it is not in."""
    before, after = (np.full_like(data.problem.observed, np.nan) for _ in range(2))
    for fold in range(_FOLDS):
        rows = np.arange(len(data.counts)) % _FOLDS == fold
        others = replace(data, counts=data.counts & ~rows[:, None])
        geometry = fit(others, explanation.geometric.g, ())
        extended = fit(others, explanation.final.g, explanation.final.effects)
        before[rows] = data.problem.predict(geometry.g, ())[rows]
        after[rows] = data.problem.predict(extended.g, extended.effects)[rows]
    return before, after
