"""Forward selection of effects with a backward step: which causes, fitted jointly with the geometry, explain the data.

1. A robust fit of the geometry alone; swapped markers and gross errors are found in what it leaves.
2. While something is left that a cause explains significantly and in a real share, the best one is added, and what was
   scanned for the others is looked for anew.
3. Every cause found is taken out once and all others are tried in its place: a better one replaces it, and those that
   the data cannot tell from it are its equivalents.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from armtwin.calib.diagnosis.acceptance import (
    CLEARLY_QUIETER,
    best_accepted,
    leaves_a_cause,
    needed_of,
    shows_more,
)
from armtwin.calib.diagnosis.candidates import CandidateModel, candidate_sites, candidates
from armtwin.calib.diagnosis.explanation import Explanation, explanation_of
from armtwin.calib.diagnosis.fit import Data, Fit, degrees_of_freedom, excess_of, fit
from armtwin.calib.diagnosis.from_part import from_part
from armtwin.calib.diagnosis.noise import estimate_noise, least_noise, robust_std
from armtwin.calib.diagnosis.problem import Problem
from armtwin.calib.diagnosis.put_back import Mended, put_back
from armtwin.calib.diagnosis.repairs import Repaired, repair
from armtwin.calib.diagnosis.replacement import Equivalents, Ranked, rescanned, settle
from armtwin.models.catalogue.predict import Active
from armtwin.models.recordings.part import Part, fair_part

Array = NDArray[np.float64]
Bool = NDArray[np.bool_]

# Up to so many poses are searched at once; of more a fair part of as many is.
_AT_ONCE = 500
# Effects at once that a recording of a few hundred poses can hold apart.
_MOST_EFFECTS = 5
# An effect that leaves less than this share of the excess explains points that look like gross errors, too.
_FEW_LEFT = 0.2
# Repairs of one model at most.
_REPAIRS = 3
# Points beyond this many standard deviations of what the geometry leaves do not pull on it.
_CAP = 6.0


def search(
    problem: Problem, rows: Bool, noise: float | None, progress: Callable[[str], None] = lambda _: None
) -> Explanation:
    """Explain the rows (N,) of a recording; of very many a fair part first, and then all of them from there."""
    part = fair_part(len(rows), _AT_ONCE)
    if part.counted.all():
        return _search(problem, rows, noise, progress)
    progress("looking at a fair part of the poses first")
    first = _search(problem.at(part.rows), rows[part.rows] & part.counted, noise, progress)
    progress("fitting what was found to all poses")
    return _search(problem, rows, noise, progress, (first, part))


def _search(
    problem: Problem,
    rows: Bool,
    noise: float | None,
    progress: Callable[[str], None],
    begin: tuple[Explanation, Part] | None = None,
) -> Explanation:
    """Explain rows from nothing, or from what a part of them showed."""
    counts = np.isfinite(problem.observed).all(axis=-1) & rows[:, None]
    noise = None if noise is None else max(noise, problem.grain_std)
    geometric, problem = robust_geometry(problem, counts, noise)
    sigma = noise if noise is not None else estimate_noise(problem, _counted(geometric.residual, counts))
    raw = Data(problem, counts, sigma, declared=noise is not None)
    considered: list[CandidateModel] = []
    alone: Ranked | None = None
    equivalents: Equivalents | None = None
    if begin is None:
        repaired = repair(raw, geometric)
        if repaired.found and _explained_without_repair(raw, geometric):
            repaired = Repaired(raw, ())
        repaired, data, base = repaired_again(raw, repaired, geometric)
    else:
        raw, model = from_part(raw, *begin)
        repaired, data, base = repaired_again(raw, repair(raw, model), model)
        considered, alone = list(begin[0].considered), begin[0].alone
        equivalents = {cause.active.key: cause.equivalents for cause in begin[0].causes}
    while len(base.effects) < _MOST_EFFECTS and (
        begin is None or shows_more(data, base, begin[0].data, begin[0].final)
    ):
        progress(f"looking for cause {len(base.effects) + 1}")
        whole = _with_every_point(raw, base, geometric.g) if base.effects and repaired.found else None
        if whole is not None:
            repaired, data, base = repaired_again(raw, repair(raw, whole), whole)
            equivalents = None
            continue
        if base.effects and not leaves_a_cause(data, base, geometric.g):
            break
        considered = candidates(data, base, candidate_sites(data, base.effects))
        alone = alone if base.effects else Ranked(data, considered)
        quieter = _quieter(data, considered)
        if quieter is not None:
            raw, data = replace(raw, noise=quieter), replace(data, noise=quieter)
            base = fit(data, base.g, base.effects)
            continue
        chosen = best_accepted(data, base, considered, geometric.g)
        if chosen is None:
            break
        model = rescanned(data, chosen.fit)
        repaired, data, base = repaired_again(raw, repair(raw, model), model)
        equivalents = None
    if equivalents is None:
        base, equivalents = settle(data, base, progress, alone)
    needed = needed_of(data, base)
    if len(needed.effects) < len(base.effects):
        base, equivalents = settle(data, needed, progress, alone)
    # What looked like a gross error beside a poorer model may be none beside the last.
    repaired, data, base = repaired_again(raw, repair(raw, base), base)
    mended = put_back(raw, Mended(repaired, data, base))
    if mended.model is not base:
        repaired, data, base = mended.repaired, mended.data, mended.model
        base, equivalents = settle(data, base, progress)
    return explanation_of(data, raw, base, repaired, equivalents, considered, alone)


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


def _quieter(data: Data, ranked: list[CandidateModel]) -> float | None:
    """Return the noise that the best candidate leaves if that is well below an undeclared noise's estimate."""
    if data.declared or not ranked:
        return None
    best = min(ranked, key=lambda candidate: float(candidate.fit.misfit.sum()))
    left = float(best.fit.misfit.sum()) / degrees_of_freedom(data, best.fit)
    quieter = max(data.noise * float(np.sqrt(left)), least_noise(data.problem))
    return quieter if quieter < CLEARLY_QUIETER * data.noise else None


def _explained_without_repair(raw: Data, geometric: Fit) -> bool:
    """Whether one fitted effect explains what look like gross errors: a rare jump of one joint moves one marker too."""
    base = fit(raw, geometric.g, ())
    ranked = candidates(raw, base, candidate_sites(raw))
    return bool(ranked) and excess_of(raw, ranked[0].fit) < _FEW_LEFT * excess_of(raw, base)


def _with_every_point(raw: Data, base: Fit, g: Array) -> Fit | None:
    """Return a model with one more cause that explains what looks like gross errors beside those that it has."""
    data = replace(raw, problem=raw.problem.with_links(base.g))
    before = fit(data, base.g, base.effects)
    chosen = best_accepted(data, before, candidates(data, before, candidate_sites(data, base.effects)), g)
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
