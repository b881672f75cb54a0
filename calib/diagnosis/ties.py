"""Which models the data cannot tell apart."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from calib.diagnosis.candidates import Candidate
    from calib.diagnosis.fit import Data

# Below this difference of scores no two models are told apart (a Bayes factor of about 50).
_LEAST_DIFFERENCE = 8.0
# Standard deviations of Vuong's statistic (Q. Vuong, Econometrica 57, 1989).
_VUONG = 2.3
# No term has exactly the world's form: a difference that is this small a share of what either explains tells nothing.
_FORM_SHARE = 0.004


def tied(data: Data, best: Candidate, other: Candidate, excess: float) -> bool:
    """Whether `other` explains the data as well as `best`, by the pose-wise differences of their misfits.

    Poses that follow one another are not independent, so the variance is that of sums over runs of poses.
    """
    by_pose = (other.fit.misfit - best.fit.misfit).sum(axis=1)[data.counts.any(axis=1)]
    difference = other.score - best.score
    runs = max(4, int(np.sqrt(len(by_pose))))
    sums = np.array([part.sum() for part in np.array_split(by_pose, runs)])
    spread = float(sums.std(ddof=1) * np.sqrt(runs))
    return difference < max(_LEAST_DIFFERENCE, _FORM_SHARE * excess) or difference < _VUONG * spread * 0.5
