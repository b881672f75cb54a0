"""The webcam of Table 2, before a board that is square to it or tilted."""

from __future__ import annotations

import numpy as np

from armtwin.models.camera import Camera
from armtwin.models.lenses import PlumbBob

# Table 2 of the paper; the rotation is set by each test.
K = np.array([[1438.6338, 0.0, 654.1560], [0.0, 1439.1291, 369.6557], [0.0, 0.0, 1.0]])
D = np.array([0.1630, 0.0428, 0.0064, 0.0016, -2.1819])


def webcam(tilt_deg: float = 0.0, axis: tuple[float, float, float] = (0.6, 0.8, 0.0)) -> Camera:
    """The paper's webcam half a metre before the board's origin, the board tilted by an angle about an axis."""
    k = np.array([[0.0, -axis[2], axis[1]], [axis[2], 0.0, -axis[0]], [-axis[1], axis[0], 0.0]])
    a = np.radians(tilt_deg)
    tilt = np.eye(3) + np.sin(a) * k + (1.0 - np.cos(a)) * k @ k
    return Camera(1280, 720, K, PlumbBob(D), tilt @ np.diag([-1.0, -1.0, 1.0]), np.array([0.0, 0.0, 485.0]))
