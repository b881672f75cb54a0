"""Forward selection of effects with a backward step: which causes, fitted jointly with the geometry, explain the data.

1. A robust fit of the geometry alone; swapped markers and gross errors are found in what it leaves.
2. While something is left that a cause explains significantly and in a real share, the best one is added, and what was
   scanned for the others is looked for anew.
3. Every cause found is taken out once and all others are tried in its place: a better one replaces it, and those that
   the data cannot tell from it are its equivalents.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from armtwin.calib.diagnosis.candidates import CandidateModel, candidate_sites, candidates, fit_candidates, fit_without
from armtwin.calib.diagnosis.fit import Data, Fit, degrees_of_freedom, evaluate, excess_of, fit
from armtwin.calib.diagnosis.noise import estimate_noise, least_noise, robust_std
from armtwin.calib.diagnosis.problem import Problem
from armtwin.calib.diagnosis.put_back import Mended, put_back
from armtwin.calib.diagnosis.repairs import Repaired, is_certain, repair
from armtwin.calib.diagnosis.replacement import Equivalents, Ranked, rescanned, settle
from armtwin.calib.diagnosis.significance import LEVEL, of_the_grain
from armtwin.models.catalogue.predict import Active

Array = NDArray[np.float64]
Bool = NDArray[np.bool_]

# Effects at once that a recording of a few hundred poses can hold apart.
_MOST_EFFECTS = 5
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
# An estimate of the noise is lowered when a model leaves less than this part of it.
_CLEARLY_QUIETER = 0.85
# An effect that leaves less than this share of the excess explains points that look like gross errors, too.
_FEW_LEFT = 0.2
# Candidates whose deviance differs by less explain the data alike: a fixed number of parameters more or less.
ALIKE = 4.0
# Of fewer poses a gross error cannot be told from a curve.
_MANY_POSES = 40
# Standard deviations (of a deviance) that candidates may gain beyond the excess by fitting noise.
_CHANCE_STDS = 4.0
# Repairs of one model at most.
_REPAIRS = 3
# Points beyond this many standard deviations of what the geometry leaves do not pull on it.
_CAP = 6.0


@dataclass(frozen=True, eq=False)
class Cause:
    """An effect of the final model, with what it explains and what could stand in its place."""

    active: Active
    p_value: float
    explained_share: float
    equivalents: tuple[Active, ...]


@dataclass(frozen=True, eq=False)
class Explanation:
    """The outcome of a search.

    Attributes:
        data: after repairs.
        untouched: as recorded.
        geometric, final: fits of the geometry alone and with all causes.
        causes: fitted ones, most explaining first.
        found: effects of single samples that were repaired or modelled.
        excess, remaining: deviance above what noise alone leaves, before and after.
        considered: scores of the last candidates that were turned down, best first.

    """

    data: Data
    untouched: Data
    geometric: Fit
    final: Fit
    causes: tuple[Cause, ...]
    found: tuple[Active, ...]
    excess: float
    remaining: float
    considered: tuple[CandidateModel, ...]


def search(
    problem: Problem, rows: Bool, noise: float | None, progress: Callable[[str], None] = lambda _: None
) -> Explanation:
    """Explain the rows (N,) of a recording."""
    counts = np.isfinite(problem.observed).all(axis=-1) & rows[:, None]
    noise = None if noise is None else max(noise, problem.grain_std)
    geometric, problem = robust_geometry(problem, counts, noise)
    sigma = noise if noise is not None else estimate_noise(problem, _counted(geometric.residual, counts))
    raw = Data(problem, counts, sigma, declared=noise is not None)
    repaired = repair(raw, geometric)
    if repaired.found and _explained_without_repair(raw, geometric):
        repaired = Repaired(raw, ())
    repaired, data, base = repaired_again(raw, repaired, geometric)
    considered: list[CandidateModel] = []
    alone: Ranked | None = None
    while len(base.effects) < _MOST_EFFECTS:
        progress(f"looking for cause {len(base.effects) + 1}")
        whole = _with_every_point(raw, base, geometric.g) if base.effects and repaired.found else None
        if whole is not None:
            repaired, data, base = repaired_again(raw, repair(raw, whole), whole)
            continue
        if base.effects and not _leaves_a_cause(data, base, geometric.g):
            break
        considered = candidates(data, base, candidate_sites(data, base.effects))
        alone = alone if base.effects else Ranked(data, considered)
        quieter = _quieter(data, considered)
        if quieter is not None:
            raw, data = replace(raw, noise=quieter), replace(data, noise=quieter)
            base = fit(data, base.g, base.effects)
            continue
        chosen = _best_accepted(data, base, considered, geometric.g)
        if chosen is None:
            break
        model = rescanned(data, chosen.fit)
        repaired, data, base = repaired_again(raw, repair(raw, model), model)
    base, equivalents = settle(data, base, progress, alone)
    needed = _needed(data, base)
    if len(needed.effects) < len(base.effects):
        base, equivalents = settle(data, needed, progress, alone)
    # What looked like a gross error beside a poorer model may be none beside the last.
    repaired, data, base = repaired_again(raw, repair(raw, base), base)
    mended = put_back(raw, Mended(repaired, data, base))
    if mended.model is not base:
        repaired, data, base = mended.repaired, mended.data, mended.model
        base, equivalents = settle(data, base, progress)
    return _explanation(data, raw, base, repaired, equivalents, considered)


def robust_geometry(problem: Problem, counts: Bool, noise: float | None) -> tuple[Fit, Problem]:
    """Fit the geometry alone, first to all points, then to those that the fit itself finds plausible."""
    sigma = 1.0 if noise is None else noise
    data = Data(problem, counts, sigma, cap=np.inf)
    state = fit(data, problem.nominal, ())
    for _ in range(4):
        problem = problem.with_links(state.g)
        data = replace(data, problem=problem, cap=_cap_for(state, counts, sigma))
        state = fit(data, state.g, ())
    return state, problem


def _leaves_a_cause(data: Data, base: Fit, g: Array) -> bool:
    """Whether what a model leaves could hold a cause that `_weighs`: nothing explains more than all that is left.

    Where the noise is only an estimate, what looks like little may be little noise and a cause.
    """
    free = degrees_of_freedom(data, base)
    left = float(base.misfit.sum())
    if not data.declared and left < _CLEARLY_QUIETER**2 * free:
        return True
    most = max(left - free, 0.0) + _CHANCE_STDS * float(np.sqrt(2.0 * free))
    return most > min(_LEAST_OF_ALL * min(_at_first(data, base, g), _usual_at_first(data, base)), _FELT * data.n_values)


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


def _quieter(data: Data, ranked: list[CandidateModel]) -> float | None:
    """Return the noise that the best candidate leaves if that is well below an undeclared noise's estimate."""
    if data.declared or not ranked:
        return None
    best = min(ranked, key=lambda candidate: float(candidate.fit.misfit.sum()))
    left = float(best.fit.misfit.sum()) / degrees_of_freedom(data, best.fit)
    quieter = max(data.noise * float(np.sqrt(left)), least_noise(data.problem))
    return quieter if quieter < _CLEARLY_QUIETER * data.noise else None


def _explained_without_repair(raw: Data, geometric: Fit) -> bool:
    """Whether one fitted effect explains what look like gross errors: a rare jump of one joint moves one marker too."""
    base = fit(raw, geometric.g, ())
    ranked = candidates(raw, base, candidate_sites(raw))
    return bool(ranked) and excess_of(raw, ranked[0].fit) < _FEW_LEFT * excess_of(raw, base)


def _with_every_point(raw: Data, base: Fit, g: Array) -> Fit | None:
    """Return a model with one more cause that explains what looks like gross errors beside those that it has."""
    data = replace(raw, problem=raw.problem.with_links(base.g))
    before = fit(data, base.g, base.effects)
    chosen = _best_accepted(data, before, candidates(data, before, candidate_sites(data, base.effects)), g)
    if chosen is None or excess_of(data, chosen.fit) > _FEW_LEFT * excess_of(data, before):
        return None
    return chosen.fit


def _cap_for(model: Fit, counts: Bool, sigma: float) -> float:
    return _CAP * max(1.0, robust_std(model.residual[counts]) / sigma)


def _counted(residual: Array, counts: Bool) -> Array:
    return np.where(counts[..., None], residual, np.nan)


def _refit(repaired: Repaired, base: Fit) -> tuple[Data, Fit]:
    """Return repaired data whose terms know the model's links, and the model refitted to them."""
    data = replace(repaired.data, problem=repaired.data.problem.with_links(base.g))
    return data, fit(data, base.g, base.effects)


def repaired_again(raw: Data, repaired: Repaired, model: Fit) -> tuple[Repaired, Data, Fit]:
    """Refit to repaired data, and repair by that fit, until the same is found: errors hide behind what they distort."""
    data, base = _refit(repaired, model)
    for _ in range(_REPAIRS if repaired.found else 0):
        again = repair(raw, base)
        if _same(again.found, repaired.found):
            break
        repaired = again
        data, base = _refit(repaired, base)
    return repaired, data, base


def _same(one: tuple[Active, ...], other: tuple[Active, ...]) -> bool:
    return [(a.key, a.values.tolist()) for a in one] == [(a.key, a.values.tolist()) for a in other]


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
    smooth = _free(data, candidate.active)
    return float(min(1.0, tries * stats.f.sf(gain / smooth, smooth, free)))


def _free(data: Data, active: Active) -> int:
    """Return how many parameters a gradient finds of an effect, at least one."""
    return max(len(active.effect.acting(data.problem.context, active.site, active.values)), 1)


def _best_accepted(data: Data, base: Fit, ranked: list[CandidateModel], g: Array) -> CandidateModel | None:
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


def _needed(data: Data, model: Fit) -> Fit:
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


def _explanation(
    data: Data,
    untouched: Data,
    base: Fit,
    repaired: Repaired,
    equivalents: Equivalents,
    considered: list[CandidateModel],
) -> Explanation:
    geometric = fit(data, base.g, ())
    final = fit(data, base.g, base.effects)
    excess = excess_of(data, geometric)
    causes = []
    for active in final.effects:
        without = fit(data, base.g, tuple(other for other in base.effects if other.key != active.key))
        gain = float(without.misfit.sum() - final.misfit.sum())
        left = max(1.0, final.misfit.sum() / degrees_of_freedom(data, final))
        k = _free(data, active)
        p_value = float(min(1.0, len(candidate_sites(data)) * stats.chi2.sf(max(gain, 0.0) / left, k)))
        share = min(gain / excess, 1.0) if excess > 0 else 0.0
        causes.append(Cause(active, p_value, share, equivalents.get(active.key, ())))
    causes.sort(key=lambda cause: -cause.explained_share)
    return Explanation(
        data=data,
        untouched=untouched,
        geometric=geometric,
        final=final,
        causes=tuple(causes),
        found=tuple(active for active in repaired.found if is_certain(untouched, final, active)),
        excess=excess,
        remaining=excess_of(data, final),
        considered=tuple(considered),
    )
