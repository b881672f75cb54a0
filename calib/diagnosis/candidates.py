"""Every effect at every site, fitted jointly with the geometry and what is already in the model."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armtwin.calib.diagnosis.fit import Data, Fit, fit
from armtwin.calib.diagnosis.repairs import find_missed
from armtwin.calib.diagnosis.screen import Screen, best_start
from armtwin.models.catalogue.predict import Active
from armtwin.models.catalogue.registry import Effect, Site, Stage, catalogue

Array = NDArray[np.float64]

# So many candidates are fitted in full, the most promising by one linearised step.
_FULL_FITS = 14
# A scan is narrowed about its best while that gains, at most so often.
_REFINEMENTS = 6


@dataclass(frozen=True, eq=False)
class CandidateModel:
    """An effect at a site, fitted: `fit` holds the whole model with this effect last.

    `complexity` is the number of parameters, scanned ones counted with the logarithm of their grid.
    """

    active: Active
    fit: Fit
    complexity: float

    @property
    def score(self) -> float:
        """Deviance plus the penalty of its complexity; smaller is better."""
        return self.fit.deviance + self.complexity


def candidate_sites(data: Data, taken: Iterable[Active] = ()) -> list[tuple[Effect, Site]]:
    """List the fitted effects and sites that this recording could show and the model has not."""
    context = data.problem.context
    held = {active.key for active in taken}
    pairs = []
    for effect in catalogue().values():
        if effect.find is not None or effect.term is None or (effect.needs_return and not context.turns_back):
            continue
        if not data.problem.is_pixels and effect.stage > Stage.JOINT:
            continue
        for site in effect.sites(context):
            if (effect.name, site.joint, site.marker) not in held and effect.applies(context, site) is None:
                pairs.append((effect, site))
    return pairs


def fit_candidates(data: Data, base: Fit, pairs: Sequence[tuple[Effect, Site]]) -> list[CandidateModel]:
    """Fit the most promising pairs on top of `base`, best first."""
    screen = Screen(data, base)
    screened = []
    for effect, site in pairs:
        best = _best_start(data, screen, effect, site)
        if best is not None:
            screened.append(best)
    screened.sort(key=lambda row: row[0])
    fitted = []
    for _, active, starts in screened[:_FULL_FITS]:
        result = fit(data, base.g, (*base.effects, active))
        fitted.append(CandidateModel(result.effects[-1], result, _complexity(data, active.effect, active.site, starts)))
    return sorted(fitted, key=lambda candidate: candidate.score)


def _best_start(data: Data, screen: Screen, effect: Effect, site: Site) -> tuple[float, Active, int] | None:
    """Return promised deviance, start and number of starts of the best one, refined where the effect offers it."""
    context = data.problem.context
    starts = [Active(effect, site, values) for values in effect.starts(context, site, None)]
    if effect.screen is not None:
        starts += [Active(effect, site, values) for values in effect.screen(context, site, screen.evidence)]
    best = best_start(screen, starts)
    if best is None:
        return None
    tried, seen = len(starts), {start.values.tobytes() for start in starts}
    for _ in range(_REFINEMENTS):
        finer = [Active(effect, site, values) for values in effect.starts(context, site, best[1].values)]
        fresh = [start for start in finer if start.values.tobytes() not in seen]
        refined = best_start(screen, fresh)
        if refined is None or refined[0] >= best[0]:
            break
        seen.update(start.values.tobytes() for start in fresh)
        tried = len(starts) + len(finer)
        best = refined
    return best[0], best[1], tried


def _complexity(data: Data, effect: Effect, site: Site, starts: int) -> float:
    """Penalty in deviance: log(n) a smooth parameter (Schwarz), twice the logarithm of the grid for scanned ones."""
    parameters = effect.parameters(data.problem.context, site)
    smooth = sum(not parameter.scanned for parameter in parameters)
    scanned = any(parameter.scanned for parameter in parameters)
    return smooth * float(np.log(max(data.n_values, 2))) + (2.0 * float(np.log(max(starts, 1))) if scanned else 0.0)


def candidates(data: Data, base: Fit, pairs: Sequence[tuple[Effect, Site]]) -> list[CandidateModel]:
    """Fitted candidates on top of `base`, the missed poses among them, best first."""
    ranked = fit_candidates(data, base, pairs)
    missed = None if any(a.effect.name == "missed_command" for a in base.effects) else find_missed(data, base)
    if missed is not None:
        result = fit(data, base.g, (*base.effects, missed))
        ranked.append(CandidateModel(missed, result, 2.0 * np.log(len(data.problem.context)) * len(missed.values)))
    return sorted(ranked, key=lambda candidate: candidate.score)
