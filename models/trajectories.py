"""Paths of the end effector: the paper's two circles and its validation line (section 4)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

# Section 4: fifty samples a trajectory, orientation pi, circles of 15 and 25 mm about (-130, 40) mm.
SAMPLES = 50
ORIENTATION_RAD = float(np.pi)
CIRCLE_CENTRE_MM = (-130.0, 40.0)
LINE_START_MM = (-145.0, 25.0)
LINE_END_MM = (-115.0, 45.0)


def circle(
    centre_mm: tuple[float, float], radius_mm: float, n: int = SAMPLES, theta_F: float = ORIENTATION_RAD
) -> Array:
    """(n, 3) poses x mm, y mm, theta rad, evenly spaced once round a circle, from its rightmost point."""
    turn = np.arange(n) * (2 * np.pi / n)
    x = centre_mm[0] + radius_mm * np.cos(turn)
    y = centre_mm[1] + radius_mm * np.sin(turn)
    return np.stack([x, y, np.full(n, theta_F)], axis=-1)


def line(
    start_mm: tuple[float, float], end_mm: tuple[float, float], n: int = SAMPLES, theta_F: float = ORIENTATION_RAD
) -> Array:
    """(n, 3) poses evenly spaced on a segment, both ends included."""
    x = np.linspace(start_mm[0], end_mm[0], n)
    y = np.linspace(start_mm[1], end_mm[1], n)
    return np.stack([x, y, np.full(n, theta_F)], axis=-1)


def paper_trajectories() -> dict[str, Array]:
    """Return the paper's three trajectories by name: two circles to calibrate on, one line to validate on."""
    return {
        "circle_15": circle(CIRCLE_CENTRE_MM, 15.0),
        "circle_25": circle(CIRCLE_CENTRE_MM, 25.0),
        "line": line(LINE_START_MM, LINE_END_MM),
    }
