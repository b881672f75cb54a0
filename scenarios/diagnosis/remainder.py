"""What a twin leaves of every sighting, in millimetres, and as the joint angles that would explain it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from armtwin.calib.diagnosis.diagnosis import Diagnosis
from armtwin.calib.diagnosis.fit import Fit
from armtwin.calib.diagnosis.holdout import in_millimetres
from armtwin.calib.diagnosis.problem import Problem
from armtwin.calib.diagnosis.repairs import repair
from armtwin.models.catalogue.evidence import Sightings
from armtwin.models.catalogue.predict import marker_points

Array = NDArray[np.float64]
Bool = NDArray[np.bool_]

# Joint errors are small: a pull towards zero of this width keeps those finite that the seen markers do not tell.
_PRIOR_RAD = 0.05


@dataclass(frozen=True, eq=False)
class Remainder:
    """Observed less predicted, for every pose.

    Attributes:
        points_mm: (N, M, 2) markers' predicted places in the robot plane; None for joint angles.
        miss_mm: (N, M, 2) in the plane, or (N, n, 1) mm at the tip for joint angles; NaN where nothing counts.
        joints_rad: (N, n) changes of the joint angles that would explain the pose best.

    """

    points_mm: Array | None
    miss_mm: Array
    joints_rad: Array

    @property
    def size_mm(self) -> Array:
        """(N,) RMS miss of a pose over what was seen of it."""
        squares = (self.miss_mm**2).sum(axis=-1)
        seen = np.isfinite(squares)
        mean = np.where(seen, squares, 0.0).sum(axis=1) / np.maximum(seen.sum(axis=1), 1)
        return np.where(seen.any(axis=1), np.sqrt(mean), np.nan)


def sightings(diagnosis: Diagnosis) -> Sightings:
    """Return all that was seen, fitted or held out, repaired by what the final model expects."""
    data, final = diagnosis.explanation.data, diagnosis.explanation.final
    observed = diagnosis.problem.observed
    seen = np.asarray(np.isfinite(observed).all(axis=-1))
    whole = replace(data, problem=replace(data.problem, observed=observed), counts=seen)
    repaired = repair(whole, final).data
    return Sightings(repaired.problem.observed, repaired.counts)


def remainder(diagnosis: Diagnosis, model: Fit, seen: Sightings) -> Remainder:
    """Return what a fitted model leaves."""
    problem = diagnosis.explanation.data.problem
    residual = seen.observed - problem.predict(model.g, model.effects)
    residual = np.where(seen.counts[..., None], residual, np.nan)
    miss = in_millimetres(problem, model.g, residual)
    if not problem.is_pixels:
        return Remainder(None, miss, residual[..., 0])
    geometry, q = problem.geometry(model.g), problem.context.q_cmd
    points = marker_points(problem.context, geometry, q)[..., :2]
    return Remainder(points, miss, _joint_errors(problem, model, points, miss))


def _joint_errors(problem: Problem, model: Fit, points: Array, miss: Array) -> Array:
    """(N, n) joint angle errors, rad, by least squares over the markers that were seen."""
    context, geometry = problem.context, problem.geometry(model.g)
    chain = np.cumsum(geometry.links * context.directions(context.q_cmd), axis=-1)
    hinges = np.concatenate([np.zeros((len(chain), 1)), chain[:, :-1]], axis=-1) + complex(*geometry.base_mm)
    at = points[..., 0] + 1j * points[..., 1]
    n = context.arm.n_joints
    turned = 1j * (at[:, :, None] - hinges[:, None, :])  # (N, M, n): motion of a marker by a joint, mm/rad
    for column, name in enumerate(context.markers):
        turned[:, column, context.arm.links_to(name) :] = 0.0
    J = np.stack([turned.real, turned.imag], axis=2).reshape(len(chain), -1, n)
    e = miss.reshape(len(chain), -1)
    seen = np.isfinite(e)
    J, e = np.where(seen[..., None], J, 0.0), np.where(seen, e, 0.0)
    spread = max(float(np.sqrt(np.mean(e[seen] ** 2))) if seen.any() else 1.0, 1e-6)
    A = np.swapaxes(J, 1, 2) @ J + np.eye(n) * (spread / _PRIOR_RAD) ** 2
    out = np.linalg.solve(A, np.einsum("npk,np->nk", J, e)[..., None])[..., 0]
    return np.where(np.any(seen, axis=1, keepdims=True), out, np.nan)
