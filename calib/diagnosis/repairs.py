"""Single samples put right before anything is fitted: swapped markers, gross errors and missed poses."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from armtwin.calib.diagnosis.fit import Data, Fit, point_misfit
from armtwin.calib.diagnosis.noise import robust_std
from armtwin.models.catalogue.predict import Active
from armtwin.models.catalogue.registry import View, effect_named

Array = NDArray[np.float64]
Bool = NDArray[np.bool_]
Channels = TypeVar("Channels", Array, Bool)

# Nine of ten values of Gaussian noise lie within so many standard deviations.
_NINETY_PERCENT = 1.645


@dataclass(frozen=True, eq=False)
class Repaired:
    """Data with swapped markers exchanged and gross errors left out, and the effects that this found."""

    data: Data
    found: tuple[Active, ...]


def find_missed(data: Data, model: Fit) -> Active | None:
    """Return the poses that the arm missed, by what `model` leaves, or None."""
    effect = effect_named("missed_command")
    assert effect.find is not None
    for site, values in effect.find(data.problem.context, _view(data, model)):
        return Active(effect, site, values)
    return None


def repair(data: Data, model: Fit) -> Repaired:
    """Exchange swapped markers and leave out gross errors, judged by what `model` leaves of the untouched data."""
    found: list[Active] = []
    observed, counts = data.problem.observed, data.counts.copy()
    if data.problem.is_pixels and len(data.problem.channels) > 1:
        swap = effect_named("marker_swap")
        assert swap.find is not None
        for site, values in swap.find(data.problem.context, _view(data, model)):
            found.append(Active(swap, site, values))
            observed = exchanged(observed, data.problem.channels, found[-1])
            counts = exchanged(counts, data.problem.channels, found[-1])  # one of the two may not have been seen
    data = replace(data, problem=replace(data.problem, observed=observed), counts=counts)
    outliers = effect_named("outliers")
    assert outliers.find is not None
    for site, values in outliers.find(data.problem.context, _view(data, model)):
        found.append(Active(outliers, site, values))
        pairs = values.reshape(-1, 2).astype(int)
        counts[pairs[:, 0], pairs[:, 1]] = False
    return Repaired(replace(data, counts=counts), tuple(found))


def cost_unrepaired(untouched: Data, repaired: Data, model: Fit, found: Active) -> tuple[float, int]:
    """Deviance that the points of a repaired effect would add if they were taken as they came, and their number."""
    predicted = repaired.problem.predict(model.g, model.effects)
    raw = point_misfit(untouched, untouched.problem.observed - predicted)
    if found.effect.name == "outliers":
        pairs = found.values.reshape(-1, 2).astype(int)
        return float(raw[pairs[:, 0], pairs[:, 1]].sum()), len(pairs)
    rows = found.values[1:].astype(int)
    left = point_misfit(repaired, repaired.problem.observed - predicted)
    return float((raw[rows] - left[rows]).sum()), 2 * len(rows)


def exchanged(observed: Channels, channels: tuple[str, ...], swap: Active) -> Channels:
    """Return the observations (N, M, d), or which of them count (N, M), with a found swap undone."""
    assert swap.site.marker is not None
    first, second, rows = channels.index(swap.site.marker), int(swap.values[0]), swap.values[1:].astype(int)
    out = observed.copy()
    out[rows, first], out[rows, second] = observed[rows, second], observed[rows, first]
    return out


def _view(data: Data, model: Fit) -> View:
    observed = np.where(data.counts[..., None], data.problem.observed, np.nan)
    predicted = data.problem.predict(model.g, model.effects)
    residual = (observed - predicted)[data.counts]
    # An imperfect model leaves a tail, which the median does not see and which is no gross error.
    tail = float(np.quantile(np.abs(residual), 0.9)) / _NINETY_PERCENT if residual.size else 0.0
    scale = max(robust_std(residual), tail, data.noise)

    def replay(commands: Array) -> Array:
        context = replace(data.problem.context, q_cmd=commands)
        return replace(data.problem, context=context).predict(model.g, model.effects)

    return View(observed, predicted, scale, replay)
