"""Joint fit of the geometry and a set of effects: Gauss-Newton with priors, bounds and a capped (robust) loss."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from armtwin.calib.diagnosis.linearisation import Linearisation, Smooth, linearise, smooth_parameters
from armtwin.calib.diagnosis.problem import Problem
from armtwin.models.catalogue.predict import Active

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
    smooth = smooth_parameters(problem, effects)
    state = evaluate(data, g, effects)
    for _ in range(iterations):
        A, b, room = _normal_equations(data, state, linearise(data, state, smooth))
        better = None
        for damping, scale in _TRIALS:
            step = _step(A, b, room, damping)
            if float(b @ step) < _CONVERGED:  # the gain that the step promises
                return state
            trial = evaluate(data, *_moved(state, smooth, scale * step))
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
    return max(data.n_values - len(model.g) - len(smooth_parameters(data.problem, model.effects)), 1)


def excess_of(data: Data, model: Fit) -> float:
    """Deviance above what noise alone would leave."""
    return max(float(model.misfit.sum()) - degrees_of_freedom(data, model), 0.0)


def point_misfit(data: Data, residual: Array) -> Array:
    """(N, M) capped squares of the residual over the noise, summed over the components of a point."""
    squares = np.nansum(residual * residual, axis=-1) / data.noise**2
    limit = residual.shape[-1] * data.cap**2
    return np.where(data.counts, np.minimum(squares, limit), 0.0)


def evaluate(data: Data, g: Array, effects: Sequence[Active]) -> Fit:
    """Return a model as it stands, without fitting anything."""
    problem = data.problem
    residual = problem.observed - problem.predict(g, effects)
    misfit = point_misfit(data, residual)
    prior = float((((g - problem.nominal) / problem.prior_std) ** 2).sum())
    for one in smooth_parameters(problem, effects):
        prior += (one.parameter.pull(effects[one.index].values[one.k]) / one.parameter.prior_std) ** 2
    return Fit(g, tuple(effects), float(misfit.sum()) + prior, misfit, residual)


def _normal_equations(data: Data, state: Fit, at: Linearisation) -> tuple[Array, Array, Array]:
    """Matrix (p, p) and right-hand side (p,) with the priors, and the room (p, 2) that the bounds leave each step.

    Points beyond the cap pull on nothing.
    """
    d = data.problem.observed.shape[-1]
    inside = state.misfit[data.counts] < d * data.cap**2
    weighted = at.J * np.repeat(inside.astype(float), d)[:, None]
    values = [state.effects[one.index].values[one.k] for one in at.smooth]
    pulls = [one.parameter.pull(value) for one, value in zip(at.smooth, values, strict=True)]
    offset = np.concatenate([data.problem.nominal - state.g, pulls])
    room = np.full((len(offset), 2), [-np.inf, np.inf])
    for row, (one, value) in enumerate(zip(at.smooth, values, strict=True), start=len(state.g)):
        room[row] = np.array(one.parameter.bounds) - value
    A = weighted.T @ at.J
    A[np.diag_indices_from(A)] += at.precision
    return A, weighted.T @ at.r + at.precision * offset, room


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


def _moved(state: Fit, smooth: Sequence[Smooth], step: Array) -> tuple[Array, tuple[Active, ...]]:
    """Return geometry and effects after a step (p,), kept inside the bounds."""
    values = [active.values.copy() for active in state.effects]
    for one, change in zip(smooth, step[len(state.g) :], strict=True):
        values[one.index][one.k] = np.clip(values[one.index][one.k] + change, *one.parameter.bounds)
    effects = (replace(active, values=moved) for active, moved in zip(state.effects, values, strict=True))
    return state.g + step[: len(state.g)], tuple(effects)
