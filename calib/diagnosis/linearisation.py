"""A fit linearised: by how much each counted value moves with geometry and smooth parameters, and what the priors say.

Search, uncertainty and the separation of rivals stand on the same derivative, residual and precision.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from armtwin.calib.diagnosis.problem import Problem
from armtwin.models.catalogue.effect import Parameter
from armtwin.models.catalogue.predict import Active

if TYPE_CHECKING:
    from armtwin.calib.diagnosis.fit import Data, Fit

Array = NDArray[np.float64]

# A one-sided difference, in standard deviations of the parameter's prior.
_STEP = 1e-4


@dataclass(frozen=True)
class Smooth:
    """A smooth parameter of a model: number `k` of effect `index`."""

    index: int
    k: int
    parameter: Parameter


@dataclass(frozen=True, eq=False)
class Linearisation:
    """Of V counted values and p parameters, the geometry's first and then the smooth ones of the effects in order.

    Attributes:
        J: (V, p) derivative over the noise.
        r: (V,) observed less predicted, over the noise.
        precision: (p,) of the priors.
        rows: (V,) the recording's row of each value.
        smooth: the effects' parameters among the p.

    """

    J: Array
    r: Array
    precision: Array
    rows: NDArray[np.int64]
    smooth: tuple[Smooth, ...]

    @property
    def curvature(self) -> Array:
        """(p, p) of half the deviance, priors included."""
        return np.asarray(self.J.T @ self.J + np.diag(self.precision))


def smooth_parameters(problem: Problem, effects: Sequence[Active]) -> tuple[Smooth, ...]:
    """Return the parameters that a gradient finds, without those that are idle in the form that an effect has."""
    context, found = problem.context, []
    for index, active in enumerate(effects):
        parameters = active.effect.parameters(context, active.site)
        acting = active.effect.acting(context, active.site, active.values)
        found += [Smooth(index, k, parameters[k]) for k in acting]
    return tuple(found)


def precision_of(problem: Problem, smooth: Sequence[Smooth]) -> Array:
    """(p,) inverse variances of the priors."""
    return np.concatenate([problem.prior_std**-2.0, [one.parameter.prior_std**-2.0 for one in smooth]])


def linearise(data: Data, model: Fit, smooth: Sequence[Smooth] | None = None) -> Linearisation:
    """Linearise a model as it stands; `smooth` where they are known already."""
    problem, counts = data.problem, data.counts
    chosen = smooth_parameters(problem, model.effects) if smooth is None else tuple(smooth)
    predicted, by_g = problem.predict_with_jacobian(model.g, model.effects)
    columns = [by_g[counts].reshape(-1, by_g.shape[-1])]
    for one in chosen:
        step = difference_step(one.parameter, model.effects[one.index].values[one.k])
        slope = (problem.predict(model.g, stepped(model.effects, one.index, one.k, step)) - predicted) / step
        columns.append(slope[counts].reshape(-1, 1))
    d = problem.observed.shape[-1]
    return Linearisation(
        J=np.concatenate(columns, axis=1) / data.noise,
        r=(problem.observed - predicted)[counts].reshape(-1) / data.noise,
        precision=precision_of(problem, chosen),
        rows=np.repeat(np.nonzero(counts)[0], d).astype(np.int64),
        smooth=chosen,
    )


def difference_step(parameter: Parameter, value: float) -> float:
    """Size of a one-sided difference, away from the nearer bound."""
    low, high = parameter.bounds
    step = _STEP * parameter.prior_std
    return step if value + step <= high and (value - low <= high - value) else -step


def stepped(effects: Sequence[Active], index: int, k: int, step: float) -> list[Active]:
    """Return the effects with value `k` of number `index` moved by `step`."""
    moved = list(effects)
    values = moved[index].values.copy()
    values[k] += step
    moved[index] = replace(moved[index], values=values)
    return moved
