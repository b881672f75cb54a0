"""Poses of the scene's bodies in the board frame."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from armtwin.models.coordinate_frames import R_ROBOT_BOARD
from armtwin.sim.render.arm_scene import tip_in_last_link
from armtwin.sim.render.solids import translation

Array = NDArray[np.float64]


def T_robot_board(base_in_board_mm: Sequence[float] | Array) -> Array:
    """(4, 4) transform from the robot frame to the board frame (equation 12); marker A stands at `base_in_board_mm`."""
    T = np.eye(4)
    T[:3, :3] = R_ROBOT_BOARD
    T[:3, 3] = base_in_board_mm
    return T


def robot_bodies_on_board(
    T_body_robot: Mapping[str, Array], base_in_board_mm: Sequence[float] | Array
) -> dict[str, Array]:
    """Carry the arm's (4, 4) poses, mm, from the robot frame to the board frame, in which the renderer draws."""
    T = T_robot_board(base_in_board_mm)
    return {name: T @ pose for name, pose in T_body_robot.items()}


def planar_arm_poses(link_lengths_mm: Sequence[float] | Array, q: Sequence[float] | Array) -> dict[str, Array]:
    """(4, 4) T_body_robot, mm, of `base`, `link1`, `end1` ... of a rigid planar arm at joint angles `q` (n,), rad.

    With a fourth length (l5) it is the paper's arm, each of whose joints adds a quarter turn (Table 1); other arms lie
    along x at zero. The simulated bench takes its poses from the physics instead.
    """
    zero = 0.5 * np.pi if len(link_lengths_mm) == len(q) + 1 else 0.0
    poses = {"base": np.eye(4)}
    T = np.eye(4)
    n = len(q)
    for k, angle in enumerate(np.asarray(q, dtype=float) + zero):
        c, s = np.cos(angle), np.sin(angle)
        turn = np.eye(4)
        turn[:2, :2] = [[c, -s], [s, c]]
        T = T @ turn
        poses[f"link{k + 1}"] = T
        end = tip_in_last_link(link_lengths_mm, n) if k == n - 1 else (link_lengths_mm[k], 0.0)
        T = T @ translation(float(end[0]), float(end[1]), 0.0)
        poses[f"end{k + 1}"] = T
    return poses
