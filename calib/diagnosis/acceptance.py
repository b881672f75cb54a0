"""When a candidate is accepted as a cause: significance, its share of what is left, its weight beside others."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from armtwin.calib.diagnosis.candidates import CandidateModel, candidate_sites, fit_candidates, fit_without
from armtwin.calib.diagnosis.fit import Data, Fit, degrees_of_freedom, evaluate, excess_of, fit
from armtwin.calib.diagnosis.significance import LEVEL, of_the_grain
from armtwin.models.catalogue.predict import Active

Array = NDArray[np.float64]

# A cause must explain this share of what is left. Of several causes the first may be one among equals; what a further
# one explains less of than half is rather the imperfect form of those already named.
FIRST_SHARE = 0.2
_FURTHER_SHARE = 0.5
# Beside a strong cause, a weak one is believed where it explains this share of all, or is felt by most values, not by
# some poses alone, and leaves nothing but noise, or next to nothing of what it found.
_LEAST_OF_ALL = 0.02
_QUIET = 1.2
_NEXT_TO_NOTHING = 0.05
_FELT = 0.4
_SOME_POSES = 0.1
# Candidates whose deviance differs by less explain the data alike: a fixed number of parameters more or less.
ALIKE = 4.0
# Of fewer poses a gross error cannot be told from a curve.
_MANY_POSES = 40
# Standard deviations (of a deviance) that candidates may gain beyond the excess by fitting noise.
_CHANCE_STDS = 4.0
# An estimate of the noise is lowered when a model leaves less than this part of it.
CLEARLY_QUIETER = 0.85


def best_accepted(data: Data, base: Fit, ranked: list[CandidateModel], g: Array) -> CandidateModel | None:
    """Return the best candidate, or where that fails its test one that is as good as it and passes.

    A simpler one at the same place is as good in units of what the best leaves: gross errors in it are no merit.
    """
    if not ranked:
        return None
    best = ranked[0]
    left = max(1.0, float(best.fit.misfit.sum()) / degrees_of_freedom(data, best.fit))
    enough = len(data.problem.context) >= _MANY_POSES
    simpler = [c for c in ranked if enough and c.active.site == best.active.site and c.complexity < best.complexity]
    alike = [c for c in ranked if c.score < best.score + ALIKE * (left if c in simpler else 1.0)]
    return next((candidate for candidate in alike if _accepted(data, base, candidate, g)), None)


def p_value_of(data: Data, without: Fit, candidate: CandidateModel) -> float:
    """Significance of a candidate by likelihood ratio, corrected for the starts and sites that were tried.

    The ratio is taken against what the larger model itself leaves, so that noise larger than declared, or a remainder
    that neither explains, is no evidence for it.
    """
    free = degrees_of_freedom(data, candidate.fit)
    left = float(candidate.fit.misfit.sum()) / free
    left = max(left, 1.0 if data.declared else (data.problem.grain_std / data.noise) ** 2)
    gain = max(without.deviance - candidate.score, 0.0) / max(left, 1e-12)
    tries = max(len(candidate_sites(data, without.effects)), 1)
    smooth = free_of(data, candidate.active)
    return float(min(1.0, tries * stats.f.sf(gain / smooth, smooth, free)))


def free_of(data: Data, active: Active) -> int:
    """Return how many parameters a gradient finds of an effect, at least one."""
    return max(len(active.effect.acting(data.problem.context, active.site, active.values)), 1)


def _accepted(data: Data, base: Fit, candidate: CandidateModel, g: Array) -> bool:
    """Whether a candidate explains the data significantly, and a real share of what is left."""
    gain = float(base.misfit.sum() - candidate.fit.misfit.sum())
    if p_value_of(data, base, candidate) >= LEVEL or of_the_grain(data, base):
        return False
    if not base.effects:
        excess = excess_of(data, base)  # none: whatever is there lies below the noise
        return excess > 0.0 and gain > FIRST_SHARE * excess
    if gain <= _FURTHER_SHARE * excess_of(data, base):
        return False
    return _weighs(data, candidate.fit, base, g)


def _weighs(data: Data, model: Fit, without: Fit, g: Array) -> bool:
    """Whether one of several causes of a model is worth its name by what it gains over the model without it."""
    fell = without.misfit - model.misfit
    gain, felt = float(fell.sum()), _of_most_poses(data, fell)
    if gain > _LEAST_OF_ALL * _at_first(data, model, g) or felt > _LEAST_OF_ALL * _usual_at_first(data, model):
        return True
    reduced = float(model.misfit.sum()) / degrees_of_freedom(data, model)
    explains = reduced < _QUIET or excess_of(data, model) < _NEXT_TO_NOTHING * gain
    return explains and felt > _FELT * data.n_values


def leaves_a_cause(data: Data, base: Fit, g: Array) -> bool:
    """Whether what a model leaves could hold a cause that `_weighs`: nothing explains more than all that is left.

    Where the noise is only an estimate, what looks like little may be little noise and a cause.
    """
    free = degrees_of_freedom(data, base)
    left = float(base.misfit.sum())
    if not data.declared and left < CLEARLY_QUIETER**2 * free:
        return True
    most = max(left - free, 0.0) + _CHANCE_STDS * float(np.sqrt(2.0 * free))
    return most > min(_LEAST_OF_ALL * min(_at_first(data, base, g), _usual_at_first(data, base)), _FELT * data.n_values)


def shows_more(data: Data, base: Fit, part: Data, of_part: Fit) -> bool:
    """Whether all poses leave plainly more than a part of them did, whose causes have been found."""
    free = degrees_of_freedom(data, base)
    left = float(base.misfit.sum()) / free
    before = max(float(of_part.misfit.sum()) / degrees_of_freedom(part, of_part), 1.0)
    quiet = _QUIET if base.effects else 1.0
    return left > quiet * before + _CHANCE_STDS * float(np.sqrt(2.0 / free))


def _single_samples(model: Fit) -> tuple[Active, ...]:
    return tuple(active for active in model.effects if active.effect.found is not None)


def _at_first(data: Data, model: Fit, g: Array) -> float:
    """Return what there was to explain but for single samples: a few far-off poses outweigh any smooth cause."""
    return excess_of(data, fit(data, g, _single_samples(model)))


def _usual_at_first(data: Data, model: Fit) -> float:
    """Return the same at all poses but those that were farthest off, by the geometry that the model has."""
    return _of_most_poses(data, evaluate(data, model.g, _single_samples(model)).misfit)


def _of_most_poses(data: Data, misfit: Array) -> float:
    """Sum by pose of (N, M) misfits, or of what they fell by, without the share of the poses in which it is largest."""
    by_pose = np.sort(misfit.sum(axis=1)[data.counts.any(axis=1)])
    return float(by_pose[: int(len(by_pose) * (1.0 - _SOME_POSES))].sum())


def needed_of(data: Data, model: Fit) -> Fit:
    """Return the model without the causes that no longer weigh once the others, and the repairs, have settled."""
    while model.effects:
        without = [_least_without(data, model, active) for active in model.effects]
        least = min(without, key=lambda rest: float(rest.misfit.sum()))
        gain = float(least.misfit.sum() - model.misfit.sum())
        if least.effects:
            weighs = _weighs(data, model, least, model.g)
        else:
            tries = len(candidate_sites(data)) * len(model.misfit)  # at every site from any row on
            weighs = gain > max(FIRST_SHARE * excess_of(data, least), float(stats.chi2.isf(LEVEL / tries, 1)))
        if weighs:
            break
        model = least
    return model


def _least_without(data: Data, model: Fit, active: Active) -> Fit:
    """Return the model without one of its effects; another one at the same joint may have a form that does for both.

    So may one of the whole arm.
    """
    best = fit_without(data, model, active)
    for other in best.effects:
        whole = other.effect.where == "arm" and other.effect.is_fitted and other.effect.told is not None
        if whole or (other.site.joint is not None and other.site == active.site):
            rest = fit(data, best.g, tuple(one for one in best.effects if one.key != other.key))
            found = fit_candidates(data, rest, [(other.effect, other.site)])
            best = min([best, *(candidate.fit for candidate in found)], key=lambda one: one.deviance)
    return best
