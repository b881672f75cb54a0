"""Where a person holds the chessboard: views that fill the picture, reach its corners and tilt to all sides."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from armtwin.models.camera import Camera, project

Array = NDArray[np.float64]

# The board is held this far from the lens, mm: nearer it would not fit into the picture, farther the panel is.
_DISTANCE_MM = (330.0, 470.0)
_LARGEST_TILT_RAD = np.radians(38.0)
_LARGEST_ROLL_RAD = np.radians(15.0)
# Every square stays this far inside the picture, px.
_MARGIN_PX = 12.0
# No point of the board is farther from the lens than this, mm: the panel behind it is at 565 mm.
_FARTHEST_MM = 540.0
# Normalised radius that a corner may have: Table 2's picture reaches 0.525, and its polynomial folds back at 0.657.
_LARGEST_RADIUS = 0.52
# The picture's parts that the views are spread over, as shares of its width and height; the tilts turn through all
# sides independently of them.
_REGIONS = [(u, v) for u in (0.25, 0.5, 0.75) for v in (0.3, 0.5, 0.7)]
_TRIES = 20000


def board_poses(camera: Camera, corners_mm: Array, n: int, rng: np.random.Generator) -> list[Array]:
    """List n transforms (4, 4) from the board held in a view to the board frame, mm; the first is the identity.

    `corners_mm` (4, 3) are the outer corners of the board's squares. The first view, the board in its mount on the
    panel, is the one that gives the camera's pose.
    """
    poses = [np.eye(4)]
    T_camera_board = np.linalg.inv(camera.T_board_camera)
    inside = replace(camera, R_board_camera=np.eye(3), t_board_camera_mm=np.zeros(3))
    for view in range(1, n):
        target = np.array(_REGIONS[(view - 1) % len(_REGIONS)])
        side = 2.0 * np.pi * (view - 1) * 0.381966  # the golden angle spreads the tilts evenly for any number of views
        poses.append(T_camera_board @ _held(inside, corners_mm, target, side, rng))
    return poses


def _held(camera: Camera, corners_mm: Array, target: Array, side: float, rng: np.random.Generator) -> Array:
    """(4, 4) transform board to camera of a view near `target` that is wholly in the picture."""
    size = np.array([camera.image_width, camera.image_height])
    centre_mm = corners_mm.mean(axis=0)
    spread = 0.05
    for attempt in range(_TRIES):
        # The longer it takes, the farther from the target the board may be held, and the flatter.
        ease = attempt / _TRIES
        tilt = rng.uniform(0.4, 1.0) * _LARGEST_TILT_RAD * (1.0 - ease)
        turn = cv2.Rodrigues(np.array([np.cos(side), np.sin(side), 0.0]) * tilt)[0]
        roll = cv2.Rodrigues(np.array([0.0, 0.0, np.pi + rng.uniform(-1, 1) * _LARGEST_ROLL_RAD]))[0]
        pixel = (target + rng.normal(0.0, spread + 0.3 * ease, 2)) * size
        ray = np.array([*((pixel - camera.K[:2, 2]) / np.diag(camera.K)[:2]), 1.0])
        T = np.eye(4)
        T[:3, :3] = turn @ roll
        T[:3, 3] = ray * rng.uniform(*_DISTANCE_MM) - T[:3, :3] @ centre_mm
        points = corners_mm @ T[:3, :3].T + T[:3, 3]
        pixels = project(camera, points)
        seen = np.hypot(*(points[:, :2] / points[:, 2:]).T).max() < _LARGEST_RADIUS
        fits = seen and (pixels > _MARGIN_PX).all() and (pixels < size - 1 - _MARGIN_PX).all()
        if fits and points[:, 2].max() < _FARTHEST_MM:
            return T
    raise ValueError("the board does not fit into the picture")
