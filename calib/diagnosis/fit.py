"""Joint fit of the geometry and a set of effects: Gauss-Newton with priors, bounds and a capped (robust) loss."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from armtwin.calib.diagnosis.problem import Problem
from armtwin.models.catalogue.predict import Active
from armtwin.models.catalogue.registry import Parameter

Array = NDArray[np.float64]
Bool = NDArray[np.bool_]

_ITERATIONS = 25
# Damping (of the normal equations' unit diagonal) and length of the steps that are tried, in this order. A shorter step
# leads down a straight valley; where effect and geometry nearly make up for one another the valley is bent, and only a
# damped step (D. Marquardt, J. SIAM 11, 1963) stays in it.
_TRIALS = ((0.0, 1.0), (0.0, 0.35), (0.0, 0.12), (1e-4, 1.0), (1e-3, 1.0), (1e-2, 1.0))
_CONVERGED = 1e-3  # of a deviance unit: far below what a likelihood ratio could notice


@dataclass(frozen=True, eq=False)
class Data:
    """What a fit weighs: the problem, which points count, their noise, and beyond how many of it a point is capped.

    `declared` says whether the recording states its noise; otherwise it is an estimate, which a better model lowers.
    """

    problem: Problem
    counts: Bool
    noise: float
    cap: float = np.inf
    declared: bool = True

    @property
    def n_values(self) -> int:
        """Number of scalar observations that count."""
        return int(self.counts.sum()) * self.problem.observed.shape[-1]


@dataclass(frozen=True, eq=False)
class Fit:
    """A fitted model.

    Attributes:
        g: (g,) geometry.
        effects: with fitted values.
        deviance: capped sum of squares over the noise, priors included.
        misfit: the same without the priors, (N, M) by point; 0 where a point does not count.
        residual: (N, M, d) observed minus predicted, in the channels' unit, NaN where not seen.

    """

    g: Array
    effects: tuple[Active, ...]
    deviance: float
    misfit: Array
    residual: Array


def fit(data: Data, g: Array, effects: Sequence[Active], iterations: int = _ITERATIONS) -> Fit:
    """Fit geometry and all smooth parameters of `effects` from a start; scanned parameters stay as they are."""
    problem = data.problem
    parameters = [active.effect.parameters(problem.context, active.site) for active in effects]
    free = [[k for k, parameter in enumerate(declared) if not parameter.scanned] for declared in parameters]
    state = evaluate(data, g, effects, parameters)
    for _ in range(iterations):
        A, b, room = _normal_equations(problem, state, parameters, free, *_linearise(data, state, parameters, free))
        better = None
        for damping, scale in _TRIALS:
            step = _step(A, b, room, damping)
            if float(b @ step) < _CONVERGED:  # the gain that the step promises
                return state
            trial = evaluate(data, *_moved(state, parameters, free, scale * step), parameters)
            if trial.deviance < state.deviance:
                better = trial
                break
        if better is None:
            break
        gained = state.deviance - better.deviance
        state = better
        if gained < _CONVERGED:
            break
    return state


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


def point_misfit(data: Data, residual: Array) -> Array:
    """(N, M) capped squares of the residual over the noise, summed over the components of a point."""
    squares = np.nansum(residual * residual, axis=-1) / data.noise**2
    limit = residual.shape[-1] * data.cap**2
    return np.where(data.counts, np.minimum(squares, limit), 0.0)


def evaluate(data: Data, g: Array, effects: Sequence[Active], parameters: Sequence[tuple[Parameter, ...]]) -> Fit:
    """Return a model as it stands, without fitting anything."""
    problem = data.problem
    residual = problem.observed - problem.predict(g, effects)
    misfit = point_misfit(data, residual)
    prior = float((((g - problem.nominal) / problem.prior_std) ** 2).sum())
    for active, declared in zip(effects, parameters, strict=True):
        prior += sum((p.pull(active.values[k]) / p.prior_std) ** 2 for k, p in enumerate(declared) if not p.scanned)
    return Fit(g, tuple(effects), float(misfit.sum()) + prior, misfit, residual)


def _linearise(
    data: Data, state: Fit, parameters: Sequence[tuple[Parameter, ...]], free: Sequence[Sequence[int]]
) -> tuple[Array, Array, Array]:
    """Whitened Jacobian (V, p), residual (V,) and weights (V,) of the counted values at `state`."""
    problem = data.problem
    predicted, by_g = problem.predict_with_jacobian(state.g, state.effects)
    counts = data.counts
    columns = [by_g[counts].reshape(-1, by_g.shape[-1])]
    for index, (active, declared) in enumerate(zip(state.effects, parameters, strict=True)):
        for k in free[index]:
            step = difference_step(declared[k], active.values[k])
            values = active.values.copy()
            values[k] += step
            moved = list(state.effects)
            moved[index] = replace(active, values=values)
            slope = (problem.predict(state.g, moved) - predicted) / step
            columns.append(slope[counts].reshape(-1, 1))
    J = np.concatenate(columns, axis=1) / data.noise
    r = (problem.observed - predicted)[counts].reshape(-1) / data.noise
    d = problem.observed.shape[-1]
    inside = state.misfit[counts] < d * data.cap**2
    return J, r, np.repeat(inside.astype(float), d)


def difference_step(parameter: Parameter, value: float) -> float:
    """Size of a one-sided difference, away from the nearer bound."""
    low, high = parameter.bounds
    step = 1e-4 * parameter.prior_std
    return step if value + step <= high and (value - low <= high - value) else -step


def _normal_equations(
    problem: Problem,
    state: Fit,
    parameters: Sequence[tuple[Parameter, ...]],
    free: Sequence[Sequence[int]],
    J: Array,
    r: Array,
    weights: Array,
) -> tuple[Array, Array, Array]:
    """Matrix (p, p) and right-hand side (p,) with the priors, and the room (p, 2) that the bounds leave each step."""
    offsets, precisions = [problem.nominal - state.g], [problem.prior_std**-2.0]
    room = [np.full((len(state.g), 2), [-np.inf, np.inf])]
    for active, declared, which in zip(state.effects, parameters, free, strict=True):
        offsets.append(np.array([declared[k].pull(active.values[k]) for k in which]))
        precisions.append(np.array([declared[k].prior_std ** -2.0 for k in which]))
        room.append(np.array([np.array(declared[k].bounds) - active.values[k] for k in which]).reshape(-1, 2))
    precision = np.concatenate(precisions)
    weighted = J * weights[:, None]
    A = weighted.T @ J
    A[np.diag_indices_from(A)] += precision
    return A, weighted.T @ r + precision * np.concatenate(offsets), np.concatenate(room)


def _step(A: Array, b: Array, room: Array, damping: float) -> Array:
    """Step (p,) of the damped normal equations; what pushes out of its bounds is held there."""
    damped = A.copy()
    damped[np.diag_indices_from(A)] *= 1.0 + damping
    low, high = room.T
    held = np.zeros(len(b), dtype=bool)
    step = np.zeros(len(b))
    for _ in range(len(b)):
        step = _reduced_step(damped, b, held)
        outward = ~held & (((low >= 0) & (step < 0)) | ((high <= 0) & (step > 0)))
        if not outward.any():
            break
        held |= outward
    return step


def _reduced_step(A: Array, b: Array, held: Bool) -> Array:
    """Solve A step = b for what is not held, scaled to a unit diagonal."""
    scale = 1.0 / np.sqrt(np.diag(A))
    inside = np.flatnonzero(~held)
    scaled = (A * scale[:, None] * scale)[np.ix_(inside, inside)]
    step = np.zeros(len(b))
    step[inside] = scale[inside] * np.linalg.solve(scaled, b[inside] * scale[inside])
    return step


def _moved(
    state: Fit, parameters: Sequence[tuple[Parameter, ...]], free: Sequence[Sequence[int]], step: Array
) -> tuple[Array, tuple[Active, ...]]:
    """Return geometry and effects after a step, kept inside the bounds."""
    g = state.g + step[: len(state.g)]
    at = len(state.g)
    effects = []
    for active, declared, which in zip(state.effects, parameters, free, strict=True):
        values = active.values.copy()
        for k in which:
            values[k] = np.clip(values[k] + step[at], *declared[k].bounds)
            at += 1
        effects.append(replace(active, values=values))
    return g, tuple(effects)
