"""Every effect at every site, fitted jointly with the geometry and what is already in the model."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armtwin.calib.diagnosis.fit import Data, Fit, evaluate, fit
from armtwin.calib.diagnosis.repairs import find_explained
from armtwin.calib.diagnosis.screen import Screen, best_start
from armtwin.models.catalogue.predict import Active
from armtwin.models.catalogue.registry import Effect, Site, Stage, catalogue

Array = NDArray[np.float64]

# So many candidates are fitted in full, the most promising by one linearised step.
_FULL_FITS = 14
# Of the first of them an effect's other form is fitted in full as well: one step says little of a frequency.
_BOTH_FORMS = 4
# A scan is narrowed about its best while that gains, at most so often.
_REFINEMENTS = 6
# A scan is repeated from a better geometry while that lowers the deviance by so much.
_WORTH_A_LOOK = 1.0


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
        if not effect.is_fitted or (effect.needs_return and not context.turns_back):
            continue
        if not data.problem.is_pixels and effect.stage > Stage.JOINT:
            continue
        for site in effect.sites(context):
            if (effect.name, site.joint, site.marker) not in held and effect.why_not(context, site) is None:
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
    for place, (_, forms, starts) in enumerate(screened[:_FULL_FITS]):
        fits = [
            _polished(data, fit(data, base.g, (*base.effects, form)))
            for form in (forms if place < _BOTH_FORMS else forms[:1])
        ]
        models = [CandidateModel(one.effects[-1], one, _complexity(data, one.effects[-1], starts)) for one in fits]
        fitted.append(min(models, key=lambda model: model.score))
    fitted.sort(key=lambda candidate: candidate.score)
    return _best_refined(data, base, fitted)


def _best_refined(data: Data, base: Fit, fitted: list[CandidateModel]) -> list[CandidateModel]:
    """Return candidates, best first, of which the best was scanned again beside what has been fitted with it."""
    if not fitted or fitted[0].active.effect.screen is not None:
        return fitted
    best = fitted[0]
    context, active = data.problem.context, best.active
    around = [Active(active.effect, active.site, v) for v in active.effect.starts(context, active.site, active.values)]
    start = best_start(Screen(data, evaluate(data, best.fit.g, best.fit.effects[:-1])), around)
    if start is None:
        return fitted
    again = fit(data, best.fit.g, (*best.fit.effects[:-1], start[1]))
    if again.deviance > best.fit.deviance - _WORTH_A_LOOK:
        return fitted
    return [CandidateModel(again.effects[-1], again, best.complexity), *fitted[1:]]


def fit_without(data: Data, model: Fit, active: Active) -> Fit:
    """Return the model refitted without one of its effects, what the residual suggests of the others looked for anew.

    They are looked for from where the whole model stands: what the effect had made up for in them shows there.
    """
    rest = tuple(other for other in model.effects if other.key != active.key)
    best = fit(data, model.g, rest)
    for other in rest:
        if other.effect.screen is not None:
            others = tuple(one for one in rest if one.key != other.key)
            for start in _suggested(data, model.g, others, other):
                trial = fit(data, model.g, (*others, start))
                best = trial if trial.deviance < best.deviance - _WORTH_A_LOOK else best
    return best


def _polished(data: Data, model: Fit) -> Fit:
    """Return the model with its last effect looked for anew from the geometry that was fitted with it."""
    if model.effects[-1].effect.screen is None:
        return model
    for _ in range(_REFINEMENTS):
        others = model.effects[:-1]
        starts = _suggested(data, model.g, others, model.effects[-1])
        better = min(
            (fit(data, model.g, (*others, start)) for start in starts), key=lambda f: f.deviance, default=model
        )
        if better.deviance > model.deviance - _WORTH_A_LOOK:
            break
        model = better
    return model


def _suggested(data: Data, g: Array, others: tuple[Active, ...], active: Active) -> list[Active]:
    """Return starts of an effect that the residual of a model without it suggests."""
    assert active.effect.screen is not None
    context = data.problem.context
    evidence = Screen(data, evaluate(data, g, others)).evidence
    return [Active(active.effect, active.site, v) for v in active.effect.screen(context, active.site, evidence)]


def _best_start(data: Data, screen: Screen, effect: Effect, site: Site) -> tuple[float, list[Active], int] | None:
    """Return promised deviance, starts and number of starts tried, the best form first and refined where it can be.

    A second start is of the effect's next best form, where it has several.
    """
    context = data.problem.context
    starts = [Active(effect, site, values) for values in effect.starts(context, site, None)]
    if effect.screen is not None:
        starts += [Active(effect, site, values) for values in effect.screen(context, site, screen.evidence)]
    forms = _best_of_forms(data, screen, starts)
    if not forms:
        return None
    best = forms[0]
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
    return best[0], [best[1], *(form[1] for form in forms[1:2])], tried


def _best_of_forms(data: Data, screen: Screen, starts: Sequence[Active]) -> list[tuple[float, Active]]:
    """Return the best start of each form: with more numbers and with fewer, the best first by what those cost too."""
    priced = starts[0].effect.complexity if starts else None
    if priced is None or starts[0].effect.screen is not None:
        best = best_start(screen, starts)
        return [] if best is None else [best]
    context, forms = data.problem.context, dict[float, list[Active]]()
    for start in starts:
        forms.setdefault(priced(context, start.values), []).append(start)
    found = [(price, best) for price, form in forms.items() if (best := best_start(screen, form)) is not None]
    return [best for _, best in sorted(found, key=lambda one: one[0] + one[1][0])]


def _complexity(data: Data, active: Active, starts: int) -> float:
    """Penalty in deviance: log(n) a smooth parameter (Schwarz), twice the logarithm of the grid for scanned ones."""
    if active.effect.complexity is not None:
        return active.effect.complexity(data.problem.context, active.values)
    if active.effect.found is not None:
        return 2.0 * float(np.log(len(data.problem.context))) * len(active.values)
    parameters = active.effect.parameters(data.problem.context, active.site)
    smooth = sum(not parameter.scanned for parameter in parameters)
    scanned = any(parameter.scanned for parameter in parameters)
    return smooth * float(np.log(max(data.n_values, 2))) + (2.0 * float(np.log(max(starts, 1))) if scanned else 0.0)


def candidates(data: Data, base: Fit, pairs: Sequence[tuple[Effect, Site]]) -> list[CandidateModel]:
    """Fitted candidates on top of `base`, and those that explain single samples, best first."""
    ranked = fit_candidates(data, base, pairs)
    for found in find_explained(data, base):
        result = fit(data, base.g, (*base.effects, found))
        ranked.append(CandidateModel(found, result, _complexity(data, found, 1)))
    return sorted(ranked, key=lambda candidate: candidate.score)
