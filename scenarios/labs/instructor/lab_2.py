"""Lab 2: the marker.

**Goals.** The student sees what each stage of a classical chain throws away, writes an estimator of a place between
samples and a linear least-squares fit, and computes a bound before he asks whether his detector is good. He tells an
offset from a scale in a table.

**Before.** The normal distribution, least squares; Fisher information is explained in two sentences.

**Time.** 75 minutes: 10 for Figure 3, 20 for the edge, 15 for the circle, 20 for the bound, 5 for Table 3, 5 for the
question.

**Where they get stuck.** *The edge*: a difference belongs half way between its two samples; noise far from the edge
is weighed by its lever, so cut what lies below a few grey levels or beyond a few pixels of the steepest place. *The
circle*: the mean of the points passes on an even circle and fails on an arc. *The bound*: the square of a Gaussian of
standard deviation s and area C has the area C²/(2√π s), and cos² is a half over the outline.

**The question.** Nothing, by symmetry: all edges move outwards alike. It harms where the disc is seen in part, where
its ground is uneven (the shift differs from side to side), and where the disc's size is used, as for the distance.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from armtwin.scenarios.labs.material.marker import LENGTHS_MM, MEASURED_MM, MM_PER_PX

Array = NDArray[np.float64]


def edge_position(x: Array, grey: Array) -> float:
    """Return the centre of gravity of the slope near the steepest place."""
    steep, between = -np.diff(grey), 0.5 * (x[1:] + x[:-1])
    middle = int(np.argmax(steep))
    near = np.abs(np.arange(len(steep)) - middle) <= 4
    steep = np.where(near & (steep > 0), steep, 0.0)
    return float((steep * between).sum() / steep.sum())


def nearest_sample(x: Array, grey: Array) -> float:
    """Return the sample at the steepest place."""
    return float(x[int(np.argmin(np.gradient(grey)))])


def centre_of(points: Array) -> Array:
    """Solve u² + v² = 2 a u + 2 b v + c."""
    A = np.column_stack([2 * points, np.ones(len(points))])
    return np.asarray(np.linalg.lstsq(A, (points**2).sum(axis=1), rcond=None)[0][:2])


def bound_px(radius_px: float, contrast: float, blur_px: float, noise: float) -> float:
    """Integrate (g cos t)² over the picture: pi r C² / (2 sqrt(pi) s)."""
    information = np.pi * radius_px * contrast**2 / (2 * np.sqrt(np.pi) * blur_px * noise**2)
    return float(1 / np.sqrt(information))


SOLUTION: dict[str, Any] = {
    "edge_position": edge_position,
    "centre_of": centre_of,
    "bound_px": bound_px,
    "edge_shift_px": float((MEASURED_MM - LENGTHS_MM).mean() / MM_PER_PX / 2),
}
WRONG: dict[str, list[Any]] = {
    "edge_position": [nearest_sample, lambda x, grey: 0.0],
    "centre_of": [lambda points: points.mean(axis=0)],
    "bound_px": [lambda *disc: bound_px(*disc) ** 2, lambda *disc: -bound_px(*disc)],
    "edge_shift_px": [float((MEASURED_MM - LENGTHS_MM).mean() / MM_PER_PX), "outwards"],
}
