"""Inverse kinematics of any planar arm: the closed form where it holds, damped least squares elsewhere."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from armtwin.models import kinematics
from armtwin.models.arm import Arm
from armtwin.models.errors import UnreachablePoseError
from armtwin.models.kinematics import Deviation
from armtwin.models.reach import reach

Array = NDArray[np.float64]

# Joints that a pose (x, y, theta) takes; with fewer the tip's place alone is asked for.
_JOINTS_OF_A_POSE = 3


def inverse(arm: Arm, poses: Array, delta: Deviation | None = None) -> Array:
    """(N, n) joint commands, rad, that bring the tip to (N, 3) poses x mm, y mm, theta rad.

    An arm of one or two joints is brought to the place alone, in whatever orientation it then has. Every pose is sought
    from the one before, so the arm stays in one branch while it can. With `delta` the commands are those of the
    deviated arm. Raises `UnreachablePoseError` that names the first pose out of reach.
    """
    poses = np.asarray(poses, dtype=float)
    if kinematics.is_closed_form(arm):
        return kinematics.inverse(arm, poses, delta=delta)
    oriented = arm.n_joints >= _JOINTS_OF_A_POSE
    finite = np.isfinite(poses[:, : 3 if oriented else 2]).all(axis=1)
    if not finite.all():
        raise _unreachable(poses, int(np.argmin(finite)), "it is no number")
    found = reach(arm, poses[:, :2], poses[:, 2] if oriented else None, delta)
    if not found.reached.all():
        row = int(np.argmin(found.reached))
        raise _unreachable(poses, row, f"the tip comes no nearer than {found.missed_mm[row]:.2f} mm")
    return found.q


def _unreachable(poses: Array, row: int, why: str) -> UnreachablePoseError:
    x, y, theta = poses[row]
    return UnreachablePoseError(
        f"pose {row} (x {x:.2f} mm, y {y:.2f} mm, theta {np.degrees(theta):.2f} deg) is out of reach: {why}"
    )
