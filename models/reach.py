"""Joint angles that bring the tip to wanted points, for any planar arm: damped least squares from the pose before.

With more joints than a point asks for, the joints move as little as they can.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armtwin.models.arm import Arm
from armtwin.models.kinematics import Deviation, forward, forward_jacobian

Array = NDArray[np.float64]

# A millimetre at the tip counts as much as this turn of it: an arm's length.
_RAD_PER_MM = 1e-2
_STEPS = 60
_CLOSED_MM = 1e-6
# Nearer than this a point counts as reached.
REACHED_MM = 1e-3
_STARTS = 24


@dataclass(frozen=True, eq=False)
class Reach:
    """(N, n) joint angles, rad, for N points, and (N,) by how much the tip still misses each, mm."""

    q: Array
    missed_mm: Array

    @property
    def reached(self) -> NDArray[np.bool_]:
        """(N,) whether each point can be reached."""
        return self.missed_mm < REACHED_MM


def reach(arm: Arm, tip_mm: Array, theta_rad: Array | None = None, delta: Deviation | None = None) -> Reach:
    """Return the joint angles for (N, 2) tip points, mm, and maybe (N,) orientations, rad (`forward`'s third column).

    Every point is sought from the angles of the one before, the first one (and one that is lost) from several poses;
    of these the one that turns its joints least is taken. What cannot be reached is approached as near as it goes.
    """
    rng = np.random.default_rng(0)
    starts = [np.zeros(arm.n_joints), *rng.uniform(-np.pi / 2, np.pi / 2, (_STARTS, arm.n_joints))]
    q = np.empty((len(tip_mm), arm.n_joints))
    missed = np.empty(len(tip_mm))
    for row, point in enumerate(tip_mm):
        theta = None if theta_rad is None else float(theta_rad[row])
        near = _approach(arm, point, theta, q[row - 1], delta) if row and missed[row - 1] < REACHED_MM else None
        if near is None or near[1] >= REACHED_MM:
            found = [_approach(arm, point, theta, start, delta) for start in starts]
            near = min(found, key=lambda one: (one[1] >= REACHED_MM, np.abs(one[0]).max() if one[1] < 1 else one[1]))
        q[row], missed[row] = near
    return Reach(q, missed)


def tip_errors(wanted: Array, theta: Array | None, tip: Array) -> Array:
    """(N, 2 or 3) what (N, 3) tips (mm, mm, rad) miss of (N, 2) points, mm, and of (N,) orientations, as mm."""
    errors = wanted - tip[:, :2]
    if theta is None:
        return errors
    turn = np.angle(np.exp(1j * (theta - tip[:, 2]))) / _RAD_PER_MM
    return np.concatenate([errors, turn[:, None]], axis=1)


def tip_slopes(arm: Arm, q: Array, oriented: bool, delta: Deviation | None = None) -> Array:
    """(N, 2 or 3, n) slopes of the tip, mm/rad, its orientation as mm like `tip_errors`."""
    slopes = forward_jacobian(arm, q, delta)[1][:, -1]
    if not oriented:
        return slopes
    return np.concatenate([slopes, np.full((len(q), 1, arm.n_joints), 1.0 / _RAD_PER_MM)], axis=1)


def _approach(
    arm: Arm, point: Array, theta: float | None, start: Array, delta: Deviation | None
) -> tuple[Array, float]:
    """Return the angles that Levenberg's steps lead to from `start`, wrapped, and the miss, mm."""
    angle = None if theta is None else np.array([theta])
    q, damping = start.copy(), 1.0
    error = tip_errors(point[None], angle, forward(arm, q[None], delta))[0]
    for _ in range(_STEPS):
        if np.linalg.norm(error) < _CLOSED_MM:
            break
        J = tip_slopes(arm, q[None], theta is not None, delta)[0]
        step = J.T @ np.linalg.solve(J @ J.T + damping * np.eye(len(J)), error)
        trial = q + step * min(1.0, 0.5 / max(float(np.abs(step).max()), 1e-12))
        after = tip_errors(point[None], angle, forward(arm, trial[None], delta))[0]
        if np.linalg.norm(after) < np.linalg.norm(error):
            q, error, damping = trial, after, max(damping / 10.0, 1e-9)
        else:
            damping *= 10.0
    turned = np.pi - np.mod(np.pi - q, 2 * np.pi)
    return turned, float(np.linalg.norm(error))
