"""Standard deviations of a fitted model: by its curvature, widened where its remainder is not independent noise."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armtwin.calib.diagnosis.fit import Data, Fit, point_misfit
from armtwin.calib.diagnosis.linearisation import linearise, stepped
from armtwin.models.catalogue.registry import Parameter
from armtwin.models.catalogue.scan import fan_about

Array = NDArray[np.float64]

# Relative distances at which the likelihood of a scanned value is looked at.
_WIDEST, _FINEST, _FAN = 0.5, 1e-6, 40
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
    at = linearise(data, model)
    J, r = at.J, at.r
    _, pose = np.unique(at.rows, return_inverse=True)
    A = at.curvature
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
    smooth = {(one.index, one.k): value for one, value in zip(at.smooth, std[len(model.g) :], strict=True)}
    effects_std = []
    for index, active in enumerate(model.effects):
        parameters = active.effect.parameters(data.problem.context, active.site)
        scanned = {
            k: _scanned_std(data, model, index, k, parameter)
            for k, parameter in enumerate(parameters)
            if parameter.scanned
        }
        # Of what is idle nothing is known but its prior.
        known = [scanned.get(k, smooth.get((index, k), one.prior_std)) for k, one in enumerate(parameters)]
        effects_std.append(np.array(known))
    return Uncertainty(covariance, std[: len(model.g)], tuple(effects_std))


def _scanned_std(data: Data, model: Fit, index: int, k: int, parameter: Parameter) -> float:
    """Standard deviation of a parameter that was found by a scan: of whole numbers, or of values on a continuum."""
    low, high = parameter.bounds
    fitted = float(model.effects[index].values[k])

    def misfit(step: float) -> float:
        residual = data.problem.observed - data.problem.predict(model.g, stepped(model.effects, index, k, step))
        return float(point_misfit(data, residual).sum()) - float(model.misfit.sum())

    whole = high - low >= 2 and fitted.is_integer()
    if whole or fitted == 0.0:
        return _whole_std(misfit, fitted, (low, high), 1.0 if whole else 1e-6)
    return _step_std(misfit, fitted, (low, high))


def _whole_std(misfit: Callable[[float], float], fitted: float, bounds: tuple[float, float], least: float) -> float:
    """Half width of the values that the data do not refuse, found by longer and longer steps away from the fitted."""
    reach = []
    for sign in (-1.0, 1.0):
        step, last = least, 0.0
        while bounds[0] <= fitted + sign * step <= bounds[1] and misfit(sign * step) <= _ONE_STD:
            last, step = step, float(np.ceil(1.5 * step / least)) * least
        reach.append(max(last, 0.5 * least))
    # A parameter that may lie anywhere in an interval has its width over sqrt(12) as standard deviation.
    return (reach[0] + reach[1]) / float(np.sqrt(12.0))


def _step_std(misfit: Callable[[float], float], fitted: float, bounds: tuple[float, float]) -> float:
    """Root mean square distance from the fitted value under the likelihood, which has steps at every scale."""
    values = np.array(fan_about(fitted, _WIDEST, _FINEST, _FAN))
    values = values[(values >= bounds[0]) & (values <= bounds[1])]
    likelihood = np.exp(-0.5 * np.array([misfit(float(value) - fitted) for value in values]).clip(0.0))
    weight = float(np.trapezoid(likelihood, values))
    spread = float(np.trapezoid(likelihood * (values - fitted) ** 2, values))
    return float(np.sqrt(spread / weight))
