"""Lab 1: the lens.

**Goals.** The student writes the pinhole and the lens as functions, mends a formula by an argument of symmetry
instead of looking it up, finds where a fitted polynomial is no lens any more, and sees that the poses of a
calibration board decide what a calibration knows, and that a stated standard deviation does not tell.

**Before.** NumPy's arrays; the pinhole camera.

**Time.** 60 minutes: 10 pinhole, 20 equation 15, 10 the fold, 15 calibration, 5 the question.

**Where they get stuck.** *The misprint*: p1 multiplies r² + 2y² in the second row; the check tells which coefficient
alone is off, and the symmetry. *The fold*: the zero of the polynomial (0.88) instead of the zero of its derivative
(0.659). *OpenCV*: float32, a list an image, size as (width, height), k3 last in its own order of coefficients.

**The question.** Beyond 0.35 the polynomial extrapolates; its third term grows with the seventh power of the radius.
The residuals on the board do not show it, since no corner was there. Photograph the board in the corner of the
picture, calibrate without that picture, and look at its residuals: a held-out picture, as in Lab 5. A board square to
the view at twice the distance looks as one at half the focal length: one number is free, as in Lab 4, and the fit
stops where it started. The standard deviation is the slope of the residuals at that place, under the assumption that
it is the one and only minimum and that the model is right.
"""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from armtwin.scenarios.labs.material.lens import TABLE_2, board_mm, views

Array = NDArray[np.float64]


def pinhole(X: Array, K: Array) -> Array:
    """Divide by the depth, then the camera matrix."""
    return X[:, :2] / X[:, 2:] * np.array([K[0, 0], K[1, 1]]) + K[:2, 2]


def distort(points: Array, k1: float, k2: float, k3: float, p1: float, p2: float) -> Array:
    """Equation 15 with r² + 2y² in its second row."""
    x, y = points.T
    r2 = x**2 + y**2
    radial = 1 + k1 * r2 + k2 * r2**2 + k3 * r2**3
    return np.stack(
        [
            radial * x + 2 * p1 * x * y + p2 * (r2 + 2 * x**2),
            radial * y + p1 * (r2 + 2 * y**2) + 2 * p2 * x * y,
        ],
        axis=-1,
    )


def as_printed(points: Array, k1: float, k2: float, k3: float, p1: float, p2: float) -> Array:
    """Equation 15 as it stands in the paper."""
    out = distort(points, k1, k2, k3, p1, p2)
    x, y = points.T
    out[:, 1] += 2 * p1 * (x**2 - y**2)
    return out


def fold_radius() -> float:
    """Find the first real root of the derivative of r (1 + k1 r² + k2 r⁴ + k3 r⁶)."""
    roots = np.roots([7 * TABLE_2["k3"], 5 * TABLE_2["k2"], 3 * TABLE_2["k1"], 1.0])  # in r²
    return float(np.sqrt(min(root.real for root in roots if abs(root.imag) < 1e-9 and root.real > 0)))


def focal_length(tilted: bool) -> float:
    """Return fx, px."""
    corners = [view.astype(np.float32) for view in views(tilted=tilted)]
    boards = [board_mm().astype(np.float32)] * len(corners)
    found: Any = cv2.calibrateCameraExtended(boards, corners, (1280, 720), None, None)  # type: ignore[call-overload]
    return float(found[1][0, 0])


_TILTED, _SQUARE = focal_length(tilted=True), focal_length(tilted=False)
SOLUTION: dict[str, Any] = {
    "pinhole": pinhole,
    "distort": distort,
    "fold_radius": fold_radius(),
    "fx_px": _TILTED,
    "fx_square_px": _SQUARE,
}
WRONG: dict[str, list[Any]] = {
    "pinhole": [lambda X, K: X[:, :2] / X[:, 2:] * K[[0, 1], [0, 1]], lambda X, K: X[:, :2]],
    "distort": [as_printed, lambda points, *coefficients: points],
    "fold_radius": [0.879, "far"],
    "fx_px": [_SQUARE],
    "fx_square_px": [_TILTED, float("nan")],
}
