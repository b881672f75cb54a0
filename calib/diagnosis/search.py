"""Forward selection of effects with a backward step: which causes, fitted jointly with the geometry, explain the data.

1. A robust fit of the geometry alone; swapped markers and gross errors are found in what it leaves.
2. While something is left that a cause explains significantly and in a real share, the best one is added.
3. Every cause found is taken out once and all others are tried in its place: a better one replaces it, and those that
   the data cannot tell from it are its equivalents.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from calib.diagnosis.candidates import Candidate, candidate_sites, fit_candidates
from calib.diagnosis.fit import Data, Fit, fit
from calib.diagnosis.noise import estimate_noise, least_noise, robust_std
from calib.diagnosis.problem import Problem
from calib.diagnosis.repairs import Repaired, find_missed, repair
from calib.diagnosis.ties import tied
from models.effects.predict import Active

Array = NDArray[np.float64]
Bool = NDArray[np.bool_]

# Family-wise level of the tests, over every site and start of the catalogue (Bonferroni, the first step of Holm).
LEVEL = 1e-3
# Effects at once that a recording of a few hundred poses can hold apart.
_MOST_EFFECTS = 3
# A cause must explain this share of what is left. Of several causes the first may be one among equals; what a further
# one explains less of than half is rather the imperfect form of those already named.
_FIRST_SHARE = 0.2
_FURTHER_SHARE = 0.5
# An estimate of the noise is lowered when a model leaves less than this part of it.
_CLEARLY_QUIETER = 0.85
# An effect that leaves less than this share of the excess explains points that look like gross errors, too.
_FEW_LEFT = 0.2
# A replacement must be better by this much deviance, or two equals would change places for ever.
_BETTER = 4.0
# Of more ties than these the best are listed; the rest is as good as unknown.
_MOST_EQUIVALENTS = 2
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
        data: after repairs, with the cap under which all fits are compared.
        geometric, final: fits of the geometry alone and with all causes.
        causes: fitted ones, most explaining first.
        found: effects of single samples that were repaired or modelled.
        excess, remaining: deviance above what noise alone leaves, before and after.
        considered: scores of the last candidates that were turned down, best first.

    """

    data: Data
    geometric: Fit
    final: Fit
    causes: tuple[Cause, ...]
    found: tuple[Active, ...]
    excess: float
    remaining: float
    considered: tuple[Candidate, ...]


def search(
    problem: Problem, rows: Bool, noise: float | None, progress: Callable[[str], None] = lambda _: None
) -> Explanation:
    """Explain the rows (N,) of a recording."""
    counts = np.isfinite(problem.observed).all(axis=-1) & rows[:, None]
    geometric, problem = robust_geometry(problem, counts, noise)
    sigma = noise if noise is not None else estimate_noise(problem, _counted(geometric.residual, counts))
    raw = Data(problem, counts, sigma, declared=noise is not None)
    repaired = repair(raw, geometric)
    if repaired.found and _explained_without_repair(raw, geometric):
        repaired = Repaired(raw, ())
    data, base = _refit(repaired, geometric)
    considered: list[Candidate] = []
    while len(base.effects) < _MOST_EFFECTS:
        progress(f"looking for cause {len(base.effects) + 1}")
        considered = _candidates(data, base, candidate_sites(data, base.effects))
        quieter = _quieter(data, considered)
        if quieter is not None:
            raw, data = replace(raw, noise=quieter), replace(data, noise=quieter)
            base = fit(data, base.g, base.effects)
            continue
        if not considered or not _accepted(data, base, considered[0]):
            break
        repaired = repair(raw, considered[0].fit)
        data, base = _refit(repaired, considered[0].fit)
    base, equivalents = _replace_each(data, base, progress)
    return _explanation(data, base, repaired, equivalents, considered)


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


def _quieter(data: Data, ranked: list[Candidate]) -> float | None:
    """Return the noise that the best candidate leaves where it is well below an undeclared noise's estimate, or None."""
    if data.declared or not ranked:
        return None
    best = min(ranked, key=lambda candidate: float(candidate.fit.misfit.sum()))
    left = float(best.fit.misfit.sum()) / degrees_of_freedom(data, best.fit)
    quieter = max(data.noise * float(np.sqrt(left)), least_noise(data.problem))
    return quieter if quieter < _CLEARLY_QUIETER * data.noise else None


def _explained_without_repair(raw: Data, geometric: Fit) -> bool:
    """Whether one fitted effect explains what look like gross errors: a rare jump of one joint moves one marker too."""
    base = fit(raw, geometric.g, ())
    ranked = _candidates(raw, base, candidate_sites(raw))
    return bool(ranked) and excess_of(raw, ranked[0].fit) < _FEW_LEFT * excess_of(raw, base)


def _cap_for(model: Fit, counts: Bool, sigma: float) -> float:
    return _CAP * max(1.0, robust_std(model.residual[counts]) / sigma)


def _counted(residual: Array, counts: Bool) -> Array:
    return np.where(counts[..., None], residual, np.nan)


def _refit(repaired: Repaired, base: Fit) -> tuple[Data, Fit]:
    """Return repaired data whose terms know the model's links, and the model refitted to them."""
    data = replace(repaired.data, problem=repaired.data.problem.with_links(base.g))
    return data, fit(data, base.g, base.effects)


def _candidates(data: Data, base: Fit, pairs: list) -> list[Candidate]:
    """Fitted candidates on top of `base`, the missed poses among them, best first."""
    candidates = fit_candidates(data, base, pairs)
    missed = None if any(a.effect.name == "missed_command" for a in base.effects) else find_missed(data, base)
    if missed is not None:
        result = fit(data, base.g, (*base.effects, missed))
        candidates.append(Candidate(missed, result, 2.0 * np.log(len(data.problem.context)) * len(missed.values)))
    return sorted(candidates, key=lambda candidate: candidate.score)


def degrees_of_freedom(data: Data, model: Fit) -> int:
    """Values minus parameters."""
    smooth = sum(
        sum(not p.scanned for p in active.effect.parameters(data.problem.context, active.site))
        for active in model.effects
    )
    return max(data.n_values - len(model.g) - smooth, 1)


def excess_of(data: Data, model: Fit) -> float:
    """Deviance above what noise alone would leave."""
    return max(float(model.misfit.sum()) - degrees_of_freedom(data, model), 0.0)


def p_value_of(data: Data, without: Fit, candidate: Candidate) -> float:
    """Significance of a candidate by likelihood ratio, corrected for the starts and sites that were tried.

    The ratio is taken against what the larger model itself leaves, so that noise larger than declared, or a remainder
    that neither explains, is no evidence for it.
    """
    free = degrees_of_freedom(data, candidate.fit)
    left = float(candidate.fit.misfit.sum()) / free
    if data.declared:
        left = max(left, 1.0)
    gain = max(without.deviance - candidate.score, 0.0) / max(left, 1e-12)
    parameters = candidate.active.effect.parameters(data.problem.context, candidate.active.site)
    tries = len(candidate_sites(data)) + 1
    smooth = max(sum(not p.scanned for p in parameters), 1)
    return float(min(1.0, tries * stats.f.sf(gain / smooth, smooth, free)))


def _accepted(data: Data, base: Fit, candidate: Candidate) -> bool:
    """Whether a candidate explains the data significantly, and a real share of what is left."""
    gain = float(base.misfit.sum() - candidate.fit.misfit.sum())
    needed = _FURTHER_SHARE if base.effects else _FIRST_SHARE
    return gain > needed * excess_of(data, base) and p_value_of(data, base, candidate) < LEVEL


def _replace_each(
    data: Data, base: Fit, progress: Callable[[str], None]
) -> tuple[Fit, dict[tuple[str, int | None, str | None], tuple[Active, ...]]]:
    """Try every other effect in the place of each; return the best model and each effect's equivalents."""
    equivalents: dict[tuple[str, int | None, str | None], tuple[Active, ...]] = {}
    for attempt in range(3):
        changed = False
        equivalents = {}
        for active in base.effects:
            progress(f"trying others in the place of {active.label}")
            rest = tuple(other for other in base.effects if other.key != active.key)
            without = fit(data, base.g, rest)
            pairs = candidate_sites(data, base.effects) + [(active.effect, active.site)]
            ranked = _candidates(data, without, pairs if active.effect.find is None else pairs[:-1])
            own = _own(ranked, active, base)
            if attempt < 2 and ranked and ranked[0].score < own.score - _BETTER:
                base, changed = ranked[0].fit, True
                break
            equivalents[active.key] = tuple(
                other.active
                for other in ranked
                if other.active.key != active.key
                and tied(data, own, other, excess_of(data, without), excess_of(data, own.fit))
            )[:_MOST_EQUIVALENTS]
        if not changed:
            break
    return base, equivalents


def _own(ranked: list[Candidate], active: Active, base: Fit) -> Candidate:
    """Return the candidate of an effect that is in the model: the better of its new fit and the one it had."""
    mine = [candidate for candidate in ranked if candidate.active.key == active.key]
    held = Candidate(active, base, mine[0].complexity if mine else 2.0 * np.log(len(base.misfit)))
    return min([held, *mine], key=lambda candidate: candidate.score)


def _explanation(
    data: Data, base: Fit, repaired: Repaired, equivalents: dict, considered: list[Candidate]
) -> Explanation:
    geometric = fit(data, base.g, ())
    final = fit(data, base.g, base.effects)
    excess = excess_of(data, geometric)
    causes = []
    for active in final.effects:
        without = fit(data, base.g, tuple(other for other in base.effects if other.key != active.key))
        gain = float(without.misfit.sum() - final.misfit.sum())
        left = max(1.0, final.misfit.sum() / degrees_of_freedom(data, final))
        k = max(sum(not p.scanned for p in active.effect.parameters(data.problem.context, active.site)), 1)
        p_value = float(min(1.0, len(candidate_sites(data)) * stats.chi2.sf(max(gain, 0.0) / left, k)))
        share = min(gain / excess, 1.0) if excess > 0 else 0.0
        causes.append(Cause(active, p_value, share, equivalents.get(active.key, ())))
    causes.sort(key=lambda cause: -cause.explained_share)
    return Explanation(
        data=data,
        geometric=geometric,
        final=final,
        causes=tuple(causes),
        found=repaired.found,
        excess=excess,
        remaining=excess_of(data, final),
        considered=tuple(considered),
    )
