"""Lab 1: the paper's webcam (Table 2), and pictures of its board, as corners."""

from __future__ import annotations

from functools import cache

import cv2
import numpy as np
from numpy.typing import NDArray

from armtwin.models.camera import Camera, to_pixels
from armtwin.models.camera_files import nominal_camera

Array = NDArray[np.float64]

# The paper's board: 7 by 10 squares of 23 mm, so 6 by 9 inner corners.
CORNERS, SQUARE_MM = (9, 6), 23.0
CORNER_NOISE_PX = 0.1
TABLE_2 = {"k1": 0.1630, "k2": 0.0428, "k3": -2.1819, "p1": 0.0064, "p2": 0.0016}
_VIEWS, _SEED = 12, 11


def camera() -> Camera:
    """Return the webcam of Table 2."""
    return nominal_camera()


def board_mm() -> Array:
    """(54, 3) inner corners of the board in its own plane, mm."""
    x, y = np.meshgrid(np.arange(CORNERS[0]), np.arange(CORNERS[1]))
    return np.asarray(np.stack([x, y, np.zeros_like(x)], axis=-1).reshape(-1, 3) * SQUARE_MM, dtype=float)


@cache
def views(*, tilted: bool) -> tuple[Array, ...]:
    """Return 12 photographs, each the (54, 2) pixels of the board's corners: held at angles, or square to the view."""
    rng = np.random.default_rng(_SEED)
    centred = board_mm() - board_mm().mean(axis=0)
    photographs = []
    for _ in range(_VIEWS):
        turn = rng.uniform(-0.6, 0.6, 2) if tilted else np.zeros(2)
        R = cv2.Rodrigues(np.array([*turn, rng.uniform(-0.3, 0.3)]))[0]
        t = np.array([rng.uniform(-40, 40), rng.uniform(-25, 25), rng.uniform(480, 640)])
        pixels = to_pixels(camera(), camera().lens.project(centred @ R.T + t))
        photographs.append(pixels + rng.normal(0, CORNER_NOISE_PX, pixels.shape))
    return tuple(photographs)
