"""Robot and board frames (equations 11 and 12): x_board = -x_robot, y_board = y_robot, z_board = -z_robot."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

# Equation (12): half a turn about y. It is its own inverse.
R_ROBOT_BOARD: Array = np.diag([-1.0, 1.0, -1.0])


def robot_to_board(points_robot_mm: Array, base_in_board_mm: Array) -> Array:
    """Map (N, 2) points of the arm's plane, or (N, 3) points, from the robot to the board frame: (N, 3) mm.

    `base_in_board_mm` is marker A, the robot's origin, in the board frame, (3,) mm.
    """
    points = np.asarray(points_robot_mm, dtype=float)
    if points.shape[-1] == 2:
        points = np.concatenate([points, np.zeros_like(points[..., :1])], axis=-1)
    return points @ R_ROBOT_BOARD + base_in_board_mm


def board_to_robot(points_board_mm: Array, base_in_board_mm: Array) -> Array:
    """Map (N, 3) board points to the robot frame, (N, 3) mm, the inverse of `robot_to_board`."""
    return (np.asarray(points_board_mm, dtype=float) - base_in_board_mm) @ R_ROBOT_BOARD
