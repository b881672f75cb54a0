"""Lab 3: the arm and its inverse.

**Goals.** The student writes forward kinematics from a D-H table, derives an inverse and holds it against the forward
one; finds a sign in a printed equation by closing the loop; knows both branches and what joint limits leave of the
reach.

**Before.** Homogeneous transforms, D-H.

**Time.** 75 minutes: 10 for the transform, 15 forwards, 10 for the miss, 25 for the inverse, 10 for branches and
reach, 5 for the question.

**Where they get stuck.** *F's row*: its −π/2 makes l5 square to l4; F = l4 along the third direction, and −i·l5 in
complex numbers. *The inverse*: with C = i·exp(iθ1)·(l1 + i·l2·exp(iθ2)), the angle θ1 is the argument of C divided by
the rest: a complex number's argument is shorter than any arctangent of fractions. *Branches*: π minus the arcsine;
the tip's orientation must stay, so θ3 changes too.

**The question.** The paper's branch only: the other one needs θ1 = 111°, beyond the servos' 90°. Their program surely
had the right sign (or `atan2` of other terms), since the measured errors are millimetres; the formula was retyped.
Five lines: FK(IK(p)) against p at random p.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from armtwin.scenarios.labs.checks.arm import printed_inverse

Array = NDArray[np.float64]

L1, L2, L4, L5 = 120.0, 121.7, 38.0, 6.73


def dh(theta: float, d: float, a: float, alpha: float) -> Array:
    """Multiply the four factors of equation 1."""
    rotate_z, shift, rotate_x = np.eye(4), np.eye(4), np.eye(4)
    rotate_z[:2, :2] = [[np.cos(theta), -np.sin(theta)], [np.sin(theta), np.cos(theta)]]
    shift[0, 3], shift[2, 3] = a, d
    rotate_x[1:3, 1:3] = [[np.cos(alpha), -np.sin(alpha)], [np.sin(alpha), np.cos(alpha)]]
    return np.asarray(rotate_z @ shift @ rotate_x)


def forward(q: Array) -> Array:
    """Add up the links as complex numbers."""
    a = np.cumsum(q + np.pi / 2, axis=1)
    z = L1 * np.exp(1j * a[:, 0]) + L2 * np.exp(1j * a[:, 1]) + (L4 - 1j * L5) * np.exp(1j * a[:, 2])
    return np.stack([z.real, z.imag, q.sum(axis=1) + np.pi], axis=-1)


def _solve(poses: Array, other: bool) -> Array:
    x, y, theta_F = poses.T
    a = theta_F - np.pi  # the sum of the joints
    C = x + 1j * y - (L4 - 1j * L5) * np.exp(1j * (a + 1.5 * np.pi))
    theta2 = -np.arcsin((np.abs(C) ** 2 - L1**2 - L2**2) / (2 * L1 * L2))
    theta2 = np.pi - theta2 if other else theta2
    theta1 = np.angle(C / (1j * (L1 + 1j * L2 * np.exp(1j * theta2))))
    return np.stack([theta1, theta2, a - theta1 - theta2], axis=-1)


def inverse(poses: Array) -> Array:
    """Solve for the paper's branch."""
    return _solve(poses, other=False)


def branches(pose: Array) -> Array:
    """Solve for both."""
    return np.concatenate([_solve(pose[None], other) for other in (False, True)])


def _worst_mm() -> float:
    turn = np.arange(50) * 2 * np.pi / 50
    circle = np.stack([-130 + 15 * np.cos(turn), 40 + 15 * np.sin(turn), np.full(50, np.pi)], axis=-1)
    return float(np.linalg.norm((forward(printed_inverse(circle)) - circle)[:, :2], axis=1).max())


SOLUTION: dict[str, Any] = {
    "dh": dh,
    "forward": forward,
    "worst_mm": _worst_mm(),
    "inverse": inverse,
    "branches": branches,
    "reach_mm": (L2 - L1, L1 + L2),
}
WRONG: dict[str, list[Any]] = {
    "dh": [lambda theta, d, a, alpha: dh(theta, d, a, alpha).T, lambda theta, d, a, alpha: dh(theta, a, d, alpha)],
    "forward": [lambda q: forward(q) * [1, 1, 0.5], lambda q: forward(q)[:, :2]],
    "worst_mm": [48.257, 15.0],
    "inverse": [printed_inverse, lambda poses: _solve(poses, other=True) * 0.99],
    "branches": [lambda pose: np.repeat(inverse(pose[None]), 2, axis=0)],
    "reach_mm": [(0.0, L1 + L2), (L1 + L2, L2 - L1)],
}
