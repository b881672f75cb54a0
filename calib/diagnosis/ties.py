"""Which models the data cannot tell apart."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from armtwin.calib.diagnosis.candidates import CandidateModel
    from armtwin.calib.diagnosis.fit import Data

# Below this difference of scores no two models are told apart (a Bayes factor of about 50).
_LEAST_DIFFERENCE = 8.0
# No term has exactly the world's form: what the best model itself fails to explain is the yardstick of any difference.
_PART_OF_REMAINDER = 0.3
# A larger difference still tells nothing where a few poses make it (Q. Vuong's statistic, Econometrica 57, 1989) and it
# is a small share of what either model explains.
_VUONG = 2.0
_SMALL_SHARE = 0.01


def tied(data: Data, best: CandidateModel, other: CandidateModel, excess: float, remaining: float) -> bool:
    """Whether `other` explains the data as well as `best`, by the pose-wise differences of their misfits.

    `excess` is what there was to explain, `remaining` what `best` leaves of it. Poses that follow one another are not
    independent, so the variance is that of sums over runs of poses.
    """
    difference = other.score - best.score
    if difference < max(_LEAST_DIFFERENCE, _PART_OF_REMAINDER * remaining):
        return True
    by_pose = (other.fit.misfit - best.fit.misfit).sum(axis=1)[data.counts.any(axis=1)]
    runs = max(4, int(np.sqrt(len(by_pose))))
    sums = np.array([part.sum() for part in np.array_split(by_pose, runs)])
    spread = float(sums.std(ddof=1) * np.sqrt(runs))
    return bool(difference < _SMALL_SHARE * excess and difference < _VUONG * spread)
