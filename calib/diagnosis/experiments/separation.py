"""How far rival models can be told apart by poses that have not been run yet.

If model A is true, what does model B miss on the new poses, after it was refitted to the old and the new data together?
With D = (A - B) / noise on the new poses, J B's derivative by geometry and parameters there, and C their covariance
from the recording, the deviance that B cannot get rid of is

    D' (1 + J C J')^-1 D = min over d of |D - J d|^2 + d' C^-1 d

the criterion of G. Box and W. Hill (Technometrics 9, 1967); without C it is that of W. Hunter and A. Reiner
(Technometrics 7, 1965). As in theirs, either may be true, so the separation is the root of the mean over A and B: where
one rival holds the other as a special case (payload with no mass is sag), only one of the two can be refuted.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import permutations

import numpy as np
from numpy.typing import NDArray

from armtwin.calib.diagnosis.experiments.poses import CandidatePlan
from armtwin.calib.diagnosis.experiments.rivals import Rivals
from armtwin.calib.diagnosis.fit import Data, Fit, fit
from armtwin.calib.diagnosis.linearisation import linearise

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Extended:
    """A recording with a candidate's poses appended: `data` counts the old points and those the new poses will show."""

    data: Data
    n_old: int


def extended(data: Data, candidate: CandidatePlan, model: Fit) -> Extended:
    """Append a candidate's poses to a recording; their observations are still unknown (NaN)."""
    problem, context = data.problem, data.problem.context
    n_old, n_new = len(context), len(candidate.q_cmd)
    longer = replace(problem, context=context.followed_by(candidate.q_cmd, candidate.name, candidate.payload_kg))
    observed = np.concatenate([problem.observed, np.full((n_new, *problem.observed.shape[1:]), np.nan)])
    longer = replace(longer, observed=observed)
    shown = np.ones((n_new, data.counts.shape[1]), dtype=bool)
    if context.camera is not None:
        pixels = longer.predict(model.g, model.effects)[n_old:]
        size = np.array([context.camera.image_width, context.camera.image_height])
        shown &= ((pixels > 0) & (pixels < size - 1)).all(axis=-1)
    return Extended(replace(data, problem=longer, counts=np.concatenate([data.counts, shown])), n_old)


def separations(at: Extended, rivals: Rivals) -> dict[tuple[int, int], float]:
    """Separation in standard deviations of each pair of rivals, to first order."""
    predicted = [_new(at, model) for model in rivals.models]
    refits = [_Refit(at, model) for model in rivals.models]
    out: dict[tuple[int, int], float] = {}
    for true, other in permutations(range(len(rivals.models)), 2):
        left = refits[other].left_over((predicted[true] - predicted[other]) / at.data.noise)
        pair = (min(true, other), max(true, other))
        out[pair] = out.get(pair, 0.0) + 0.5 * left
    return {pair: float(np.sqrt(mean)) for pair, mean in out.items()}


def confirmed(at: Extended, rivals: Rivals) -> dict[tuple[int, int], float]:
    """The same by refitting each rival to the recording and what each other predicts for the new poses."""
    out: dict[tuple[int, int], float] = {}
    for true, other in permutations(range(len(rivals.models)), 2):
        truth, rival = rivals.models[true], rivals.models[other]
        observed = at.data.problem.observed.copy()
        observed[at.n_old :] = at.data.problem.predict(truth.g, truth.effects)[at.n_old :]
        data = replace(at.data, problem=replace(at.data.problem, observed=observed), cap=np.inf)
        old = replace(data, counts=data.counts & (np.arange(len(observed)) < at.n_old)[:, None])
        before, after = (fit(which, rival.g, rival.effects).deviance for which in (old, data))
        pair = (min(true, other), max(true, other))
        out[pair] = out.get(pair, 0.0) + 0.5 * max(after - before, 0.0)
    return {pair: float(np.sqrt(mean)) for pair, mean in out.items()}


class _Refit:
    """What a model leaves of a change of the new observations once it was refitted."""

    def __init__(self, at: Extended, model: Fit) -> None:
        # The new observations are unknown and so are residuals there; only the derivative is wanted.
        known = np.where(np.isfinite(at.data.problem.observed), at.data.problem.observed, 0.0)
        data = replace(at.data, problem=replace(at.data.problem, observed=known))
        fitted = linearise(data, model)
        old = int(at.data.counts[: at.n_old].sum()) * at.data.problem.observed.shape[-1]
        self._J = fitted.J[old:]
        self._A = fitted.curvature

    def left_over(self, change: Array) -> float:
        """Deviance that remains of a change (V,) in standard deviations."""
        scale = 1.0 / np.sqrt(np.diag(self._A))
        b = scale * (self._J.T @ change)
        step = np.linalg.lstsq(self._A * scale[:, None] * scale, b, rcond=1e-13)[0]
        return max(float(change @ change - b @ step), 0.0)


def _new(at: Extended, model: Fit) -> Array:
    """Values predicted for the new points that count, flattened."""
    pixels = at.data.problem.predict(model.g, model.effects)[at.n_old :]
    return np.asarray(pixels[at.data.counts[at.n_old :]].reshape(-1))
