"""Effects of single samples: found in what a model leaves, and put right before anything is fitted, or explained."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from armtwin.calib.diagnosis.fit import Data, Fit, evaluate, fit, point_misfit
from armtwin.calib.diagnosis.noise import robust_std
from armtwin.models.catalogue.effect import Effect
from armtwin.models.catalogue.evidence import Sightings, View
from armtwin.models.catalogue.predict import Active
from armtwin.models.catalogue.registry import catalogue

Array = NDArray[np.float64]

# Nine of ten values of Gaussian noise lie within so many standard deviations.
_NINETY_PERCENT = float(stats.norm.ppf(0.95))
# Samples are looked for again so often: each look starts from the poses that the one before put right.
_LOOKS = 4


@dataclass(frozen=True, eq=False)
class Repaired:
    """Data whose single samples were put right or left out, and the effects that this found."""

    data: Data
    found: tuple[Active, ...]


def find_explained(data: Data, model: Fit) -> list[Active]:
    """Return what is found in what `model` leaves of the effects whose term explains the samples."""
    held = {active.effect.name for active in model.effects}
    wanted = [effect for effect in _found_effects() if effect.term is not None and effect.name not in held]
    found = {
        _key(active): active
        for effect in wanted
        for tail in (True, False)
        for active in find(effect, data, model, tail)
    }
    return list(found.values())


def refound(data: Data, model: Fit) -> Fit:
    """Return the model with its explained single samples found anew, now that its geometry and the rest are better."""
    for index, active in enumerate(model.effects):
        if active.effect.found is None:
            continue
        for _ in range(_LOOKS):
            before, after = model.effects[:index], model.effects[index + 1 :]
            bare = evaluate(data, model.g, (*before, *after))
            again = [one for tail in (True, False) for one in find(active.effect, data, bare, tail)]
            fresh = [one for one in again if one.site == active.site and _key(one) != _key(model.effects[index])]
            trials = [fit(data, model.g, (*before, one, *after)) for one in fresh]
            better = min(trials, key=lambda trial: _priced(data, trial, index), default=model)
            if _priced(data, better, index) >= _priced(data, model, index):
                break
            model = better
    return model


def _priced(data: Data, model: Fit, index: int) -> float:
    """Deviance and what the samples of one effect cost."""
    active = model.effects[index]
    price = active.effect.complexity
    return model.deviance + (0.0 if price is None else price(data.problem.context, active.values))


def _key(active: Active) -> tuple[object, ...]:
    return (active.key, active.values.tobytes())


def find(effect: Effect, data: Data, model: Fit, tail: bool = True) -> list[Active]:
    """Return where `effect` is found in what `model` leaves, measured with its `tail` or by the middle of it alone."""
    context = data.problem.context
    if effect.found is None or all(effect.why_not(context, site) is not None for site in effect.sites(context)):
        return []
    return [Active(effect, site, values) for site, values in effect.found.find(context, _view(data, model, tail))]


def repair(data: Data, model: Fit) -> Repaired:
    """Put right or leave out what is found of the repaired effects, judged by what `model` leaves of untouched data.

    What takes whatever is far off is not shown the poses that an effect of single samples would explain.
    """
    found: list[Active] = []
    for effect in _found_effects():
        if effect.found is not None and effect.found.repair is not None:
            shown = _without_explained(data, model) if effect.found.last else data
            for active in find(effect, shown, model):
                found.append(active)
                data = repaired(data, active)
    return Repaired(data, tuple(found))


def _without_explained(data: Data, model: Fit) -> Data:
    """Return the data without the rows that effects of single samples explain."""
    counts = data.counts.copy()
    for effect in _found_effects():
        if effect.term is not None:
            for active in find(effect, data, model):
                counts[active.values.astype(int)] = False
    return replace(data, counts=counts)


def is_certain(untouched: Data, model: Fit, active: Active) -> bool:
    """Whether what was put right is worth a name: noise with tails has far points that are left out alone."""
    how = active.effect.found
    if how is None or how.certain is None:
        return True
    return how.certain(untouched.problem.context, _view(untouched, model, True), active.site, active.values)


def repaired(data: Data, active: Active) -> Data:
    """Return the data with what was found of one effect put right or left out."""
    assert active.effect.found is not None
    assert active.effect.found.repair is not None
    seen = Sightings(data.problem.observed, data.counts)
    seen = active.effect.found.repair(data.problem.context, seen, active.site, active.values)
    return replace(data, problem=replace(data.problem, observed=seen.observed), counts=seen.counts)


def cost_unrepaired(untouched: Data, after: Data, model: Fit, found: Active) -> tuple[float, int]:
    """Deviance that the points of a repaired effect would add if they were taken as they came, and their number.

    `after` are the data with all repairs.
    """
    alone = repaired(untouched, found)
    before = Sightings(untouched.problem.observed, untouched.counts)
    touched = before.differ(Sightings(alone.problem.observed, alone.counts))
    predicted = after.problem.predict(model.g, model.effects)
    raw = point_misfit(untouched, untouched.problem.observed - predicted)
    left = point_misfit(after, after.problem.observed - predicted)
    return float((raw - left)[touched].sum()), int(touched.sum())


def _found_effects() -> list[Effect]:
    """Effects of single samples, those last that take whatever is far off."""
    found = [effect for effect in catalogue().values() if effect.found is not None]
    return sorted(found, key=lambda effect: effect.found is not None and effect.found.last)


def _view(data: Data, model: Fit, with_tail: bool) -> View:
    observed = np.where(data.counts[..., None], data.problem.observed, np.nan)
    predicted = data.problem.predict(model.g, model.effects)
    residual = (observed - predicted)[data.counts]
    # An imperfect model leaves a tail, which the median does not see and which is no gross error.
    tail = float(np.quantile(np.abs(residual), 0.9)) / _NINETY_PERCENT if with_tail and residual.size else 0.0
    scale = max(robust_std(residual), tail, data.noise)

    def replay(commands: Array) -> Array:
        context = replace(data.problem.context, q_cmd=commands)
        return replace(data.problem, context=context).predict(model.g, model.effects)

    return View(observed, predicted, scale, replay)
