"""Which models the data cannot tell apart."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from armtwin.calib.diagnosis.candidates import CandidateModel
    from armtwin.calib.diagnosis.fit import Data

# Below this difference of scores no two models are told apart (a Bayes factor of about 50).
LEAST_DIFFERENCE = 8.0
# No term has exactly the world's form: what the best model itself fails to explain is the yardstick of any difference.
PART_OF_REMAINDER = 0.3
# A larger difference still tells nothing where a few poses make it (Q. Vuong's statistic, Econometrica 57, 1989) and it
# is a small share of what either model explains.
VUONG = 2.0
SMALL_SHARE = 0.01


def widest_tie(excess: float, remaining: float) -> float:
    """Return the difference of scores beyond which nothing ties, whatever poses make it."""
    return max(LEAST_DIFFERENCE, PART_OF_REMAINDER * remaining, SMALL_SHARE * excess)


def _as_free(data: Data, best: CandidateModel, other: CandidateModel) -> bool:
    """Whether two have as many numbers that a gradient finds: then only the grids that were scanned differ in price.

    A servo that stops short of a threshold that no move falls below moves as play does, and no data say otherwise.
    """
    context = data.problem.context
    free = [len(one.active.effect.acting(context, one.active.site, one.active.values)) for one in (best, other)]
    return best.active.site == other.active.site and free[0] == free[1]


def _misfit(candidate: CandidateModel) -> float:
    return float(candidate.fit.misfit.sum())


def tied(data: Data, best: CandidateModel, other: CandidateModel, excess: float, remaining: float) -> bool:
    """Whether `other` explains the data as well as `best`, by the pose-wise differences of their misfits.

    `excess` is what there was to explain, `remaining` what `best` leaves of it. Poses that follow one another are not
    independent, so the variance is that of sums over runs of poses.
    """
    difference = other.score - best.score
    least = max(LEAST_DIFFERENCE, PART_OF_REMAINDER * remaining)
    if difference < least or (_as_free(data, best, other) and _misfit(other) - _misfit(best) < least):
        return True
    by_pose = (other.fit.misfit - best.fit.misfit).sum(axis=1)[data.counts.any(axis=1)]
    runs = max(4, int(np.sqrt(len(by_pose))))
    sums = np.array([part.sum() for part in np.array_split(by_pose, runs)])
    spread = float(sums.std(ddof=1) * np.sqrt(runs))
    return bool(difference < SMALL_SHARE * excess and difference < VUONG * spread)
