"""The plumb-bob model (equation 15; Brown 1966, Decentering distortion of lenses), OpenCV's order of coefficients.

Equation (15) prints r² + 2u² in its second row; the model, as everywhere else, has r² + 2v².
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from armtwin.models.lenses.pinhole import PinholeLens, first_positive_root

Array = NDArray[np.float64]


class PlumbBob(PinholeLens):
    """Three radial and two tangential coefficients; Table 2's folds back at the normalised radius 0.657."""

    model = "plumb_bob"
    names = ("k1", "k2", "p1", "p2", "k3")

    def distort(self, points: Array) -> Array:
        """Map (..., 2) corrected to distorted normalised coordinates (equation 15)."""
        k1, k2, p1, p2, k3 = self.coefficients
        x, y = points[..., 0], points[..., 1]
        r2 = x * x + y * y
        radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))
        out = np.empty_like(points)
        out[..., 0] = x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x)
        out[..., 1] = y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y
        return out

    def distort_jacobian(self, points: Array) -> Array:
        """(..., 2, 2) derivative of `distort` by its points."""
        k1, k2, p1, p2, k3 = self.coefficients
        x, y = points[..., 0], points[..., 1]
        r2 = x * x + y * y
        radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))
        slope = k1 + r2 * (2.0 * k2 + r2 * 3.0 * k3)  # d radial / d r2
        cross = 2.0 * x * y * slope + 2.0 * p1 * x + 2.0 * p2 * y
        J = np.empty((*points.shape[:-1], 2, 2))
        J[..., 0, 0] = radial + 2.0 * x * x * slope + 2.0 * p1 * y + 6.0 * p2 * x
        J[..., 0, 1] = cross
        J[..., 1, 0] = cross
        J[..., 1, 1] = radial + 2.0 * y * y * slope + 6.0 * p1 * y + 2.0 * p2 * x
        return J

    def distort_coefficient_jacobian(self, points: Array) -> Array:
        """(..., 2, 5) derivative of `distort` by the coefficients."""
        x, y = points[..., 0], points[..., 1]
        r2 = x * x + y * y
        in_x = [x * r2, x * r2**2, 2.0 * x * y, r2 + 2.0 * x * x, x * r2**3]
        in_y = [y * r2, y * r2**2, r2 + 2.0 * y * y, 2.0 * x * y, y * r2**3]
        return np.stack([np.stack(in_x, axis=-1), np.stack(in_y, axis=-1)], axis=-2)

    def radial(self, radius: Array) -> Array:
        """Distorted of (N,) corrected radii."""
        k1, k2, _, _, k3 = self.coefficients
        r2 = radius * radius
        return np.asarray(radius * (1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))))

    @property
    def limit_rad(self) -> float:
        """Where r (1 + k1 r² + k2 r⁴ + k3 r⁶) turns back, as an angle; a quarter turn where it never does."""
        k1, k2, _, _, k3 = self.coefficients
        return float(np.arctan(np.sqrt(first_positive_root(np.array([7.0 * k3, 5.0 * k2, 3.0 * k1, 1.0])))))
