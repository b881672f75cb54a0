"""Standard deviations of a fitted model: by its curvature, widened where its remainder is not independent noise."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from calib.diagnosis.fit import Data, Fit, difference_step
from models.effects.predict import Active
from models.effects.registry import Parameter

Array = NDArray[np.float64]

# Deviance by which a scanned parameter's value is still within one standard deviation.
_ONE_STD = 1.0


@dataclass(frozen=True, eq=False)
class Uncertainty:
    """Covariance (p, p) of geometry and smooth parameters, in their order, and std of every effect's parameters."""

    covariance: Array
    geometry_std: Array
    effects_std: tuple[Array, ...]


def uncertainty(data: Data, model: Fit) -> Uncertainty:
    """Return the covariance of a fit.

    A covariance that assumes the model is right is wrong exactly when it matters. The sandwich over runs of poses (W.
    Newey and K. West, Econometrica 55, 1987, with a rectangular window) does not; of both the larger is reported.
    """
    context = data.problem.context
    parameters = [active.effect.parameters(context, active.site) for active in model.effects]
    J, r, pose = whitened(data, model, parameters)
    precision = np.concatenate(
        [data.problem.prior_std**-2.0, *([p.prior_std**-2.0 for p in of if not p.scanned] for of in parameters)]
    )
    A = J.T @ J + np.diag(precision)
    scale = 1.0 / np.sqrt(np.diag(A))
    inverse = np.linalg.pinv(A * scale[:, None] * scale, rcond=1e-14, hermitian=True) * scale[:, None] * scale
    free = max(len(r) - J.shape[1], 1)
    covariance = inverse * max(1.0, float(r @ r) / free)
    groups = max(8, int(np.sqrt(pose[-1] + 1)))
    scores = np.zeros((groups, J.shape[1]))
    np.add.at(scores, pose * groups // (pose[-1] + 1), J * r[:, None])
    sandwich = inverse @ (scores.T @ scores) @ inverse * (groups / (groups - 1))
    widen = np.sqrt(np.maximum(1.0, np.diag(sandwich) / np.diag(covariance)))
    covariance = covariance * widen[:, None] * widen
    std = np.sqrt(np.diag(covariance))
    at = len(model.g)
    effects_std = []
    for index, of in enumerate(parameters):
        values = np.zeros(len(of))
        for k, parameter in enumerate(of):
            if parameter.scanned:
                values[k] = _scanned_std(data, model, index, k, parameter)
            else:
                values[k] = std[at]
                at += 1
        effects_std.append(values)
    return Uncertainty(covariance, std[: len(model.g)], tuple(effects_std))


def whitened(data: Data, model: Fit, parameters: list[tuple[Parameter, ...]]) -> tuple[Array, Array, NDArray[np.int64]]:
    """Jacobian (V, p), residual (V,) over the noise, and the pose (V,) of each counted value, counted from 0."""
    predicted, by_g = data.problem.predict_with_jacobian(model.g, model.effects)
    counts = data.counts
    columns = [by_g[counts].reshape(-1, by_g.shape[-1])]
    for index, (active, of) in enumerate(zip(model.effects, parameters, strict=True)):
        for k, parameter in enumerate(of):
            if not parameter.scanned:
                step = difference_step(parameter, active.values[k])
                slope = (data.problem.predict(model.g, _with(model.effects, index, k, step)) - predicted) / step
                columns.append(slope[counts].reshape(-1, 1))
    d = data.problem.observed.shape[-1]
    rows = np.repeat(np.nonzero(counts)[0], d)
    _, pose = np.unique(rows, return_inverse=True)
    residual = (data.problem.observed - predicted)[counts].reshape(-1)
    return np.concatenate(columns, axis=1) / data.noise, residual / data.noise, pose.astype(np.int64)


def _with(effects: tuple[Active, ...], index: int, k: int, step: float) -> list[Active]:
    moved = list(effects)
    values = moved[index].values.copy()
    values[k] += step
    moved[index] = replace(moved[index], values=values)
    return moved


def _scanned_std(data: Data, model: Fit, index: int, k: int, parameter: Parameter) -> float:
    """Half width of the values that the data do not refuse, found by doubling steps away from the fitted one."""
    low, high = parameter.bounds
    fitted = float(model.effects[index].values[k])
    whole = high - low >= 2 and fitted.is_integer()
    least = 1.0 if whole else 1e-4 * max(abs(fitted), 1e-6)
    reach = []
    for sign in (-1.0, 1.0):
        step, last = least, 0.0
        while low <= fitted + sign * step <= high:
            residual = data.problem.observed - data.problem.predict(
                model.g, _with(model.effects, index, k, sign * step)
            )
            squares = np.nansum(residual * residual, axis=-1) / data.noise**2
            if float(squares[data.counts].sum()) - float(model.misfit.sum()) > _ONE_STD:
                break
            last, step = step, 1.5 * step
            if whole:
                step = float(np.ceil(step))
        reach.append(max(last, 0.5 * least))
    # A parameter that may lie anywhere in an interval has its width over sqrt(12) as standard deviation.
    return (reach[0] + reach[1]) / float(np.sqrt(12.0))
