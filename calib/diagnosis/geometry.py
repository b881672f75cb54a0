"""The geometry of a diagnosis in the terms of Table 4: lengths, zeros, base; and what the data cannot tell."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armtwin.calib.diagnosis.fit import Data, Fit
from armtwin.calib.diagnosis.problem import Problem
from armtwin.models.catalogue.registry import catalogue
from armtwin.models.kinematics import Deviation

Array = NDArray[np.float64]

# A direction of the geometry that the data narrow by less than this factor below its prior was not measured.
_MEASURED = 0.2


@dataclass(frozen=True, eq=False)
class GeometryReport:
    """Identifiable geometry with standard deviations, and the gauge in words.

    `names`, `values` and `std` are (k,); lengths in mm, angles in rad. `deviation` is the same as a `Deviation` from
    the drawing, under the convention that the gauge names; `base_in_board_mm` (3,) is marker A's axis.
    """

    names: tuple[str, ...]
    values: Array
    std: Array
    identifiable: int
    gauge: tuple[str, ...]
    deviation: Deviation
    base_in_board_mm: Array


def geometry_report(data: Data, model: Fit, covariance: Array) -> GeometryReport:
    """Return what the fit says of the arm."""
    problem = data.problem
    n = problem.context.arm.n_joints
    if not problem.is_pixels:
        names = tuple(f"theta{joint + 1}_zero_rad" for joint in range(n))
        zeros = Deviation(np.zeros_like(problem.context.arm.link_lengths_mm), model.g)
        std = np.sqrt(np.diag(covariance))[:n]
        hidden = ("link lengths: joint angles alone do not show them",)
        return GeometryReport(names, model.g, std, n, hidden, zeros, np.zeros(3))
    values, names = _physical(problem, model.g), _names(problem)
    J = np.stack([_slope(problem, model.g, k) for k in range(len(model.g))], axis=-1)
    std = np.sqrt(np.maximum(np.diag(J @ covariance[: len(model.g), : len(model.g)] @ J.T), 0.0))
    known = _measured_directions(data, model)
    gauge = [f"{effect.name}: {effect.gauge}" for effect in catalogue().values() if effect.gauge is not None]
    if problem.context.arm.has_tip_offset and problem.context.arm.form.corner not in problem.context.markers:
        gauge.append(
            "theta3's zero against a rotation of (l4, l5): the same motion for every pose; the drawing's angle between "
            "l4 and l5 is kept, so that the zero carries it; marker E on the corner breaks the tie"
        )
    missing = len(model.g) - known
    if missing > 0:
        gauge.append(
            f"{missing} of {len(model.g)} directions of base and links are not told by these poses and markers and are "
            "kept near the drawing; more varied poses, or marker A, break the tie"
        )
    base = problem.base_in_board_mm + np.array([-model.g[0], model.g[1], 0.0])
    return GeometryReport(
        names, values, std, max(min(known - 2, len(names) - 2), 0), tuple(gauge), _deviation(problem, values), base
    )


def _names(problem: Problem) -> tuple[str, ...]:
    arm = problem.context.arm
    lengths = [f"{name}_mm" for name in arm.link_names]
    zeros = [f"theta{k + 1}_zero_rad" for k in range(arm.n_joints)]
    return ("base_x_mm", "base_y_mm", *lengths, *zeros)


def _physical(problem: Problem, g: Array) -> Array:
    """Base in the board frame, mm, link lengths, mm, and joint zeros, rad, of the fitted chain."""
    base = problem.base_in_board_mm[:2] + np.array([-g[0], g[1]])
    links = problem.geometry(g).links
    turned = np.angle(links * np.conj(problem.geometry(problem.nominal).links))
    zeros = np.diff(np.unwrap(turned), prepend=0.0)
    return np.concatenate([base, np.abs(links), zeros])


def _slope(problem: Problem, g: Array, k: int) -> Array:
    step = np.zeros(len(g))
    step[k] = 1e-5
    return (_physical(problem, g + step) - _physical(problem, g - step)) / 2e-5


def _measured_directions(data: Data, model: Fit) -> int:
    """Count the directions of the geometry that the data narrow well below the prior."""
    _, by_g = data.problem.predict_with_jacobian(model.g, model.effects)
    J = by_g[data.counts].reshape(-1, len(model.g)) / data.noise * data.problem.prior_std
    return int((np.linalg.svd(J, compute_uv=False) > 1.0 / _MEASURED).sum())


def _deviation(problem: Problem, values: Array) -> Deviation:
    """Return link lengths and joint zeros as departures from the drawing, with l4 : l5 as drawn."""
    arm = problem.context.arm
    n = arm.n_joints
    lengths = values[2 : 2 + n]
    if arm.has_tip_offset:
        drawn = np.hypot(*arm.link_lengths_mm[-2:])
        lengths = np.concatenate([lengths[:-1], arm.link_lengths_mm[-2:] * lengths[-1] / drawn])
    return Deviation(lengths - arm.link_lengths_mm, values[2 + n :])
