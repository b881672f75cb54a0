"""The rational model: the plumb bob's radial polynomial over another one (OpenCV's `CALIB_RATIONAL_MODEL`).

It holds wide lenses that no polynomial of five coefficients follows (Claus and Fitzgibbon 2005).
"""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from armtwin.models.lenses.pinhole import PinholeLens, first_positive_root

Array = NDArray[np.float64]


class Rational(PinholeLens):
    """Radial (1 + k1 r² + k2 r⁴ + k3 r⁶) / (1 + k4 r² + k5 r⁴ + k6 r⁶), and two tangential coefficients."""

    model = "rational_polynomial"
    names: ClassVar[tuple[str, ...]] = ("k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6")

    def distort(self, points: Array) -> Array:
        """Map (..., 2) corrected to distorted normalised coordinates."""
        p1, p2 = self.coefficients[2:4]
        x, y = points[..., 0], points[..., 1]
        r2 = x * x + y * y
        scale, _ = self._scale(r2)
        out = np.empty_like(points)
        out[..., 0] = x * scale + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x)
        out[..., 1] = y * scale + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y
        return out

    def distort_jacobian(self, points: Array) -> Array:
        """(..., 2, 2) derivative of `distort` by its points."""
        p1, p2 = self.coefficients[2:4]
        x, y = points[..., 0], points[..., 1]
        scale, slope = self._scale(x * x + y * y)
        J = np.empty((*points.shape[:-1], 2, 2))
        J[..., 0, 0] = scale + 2.0 * x * x * slope + 2.0 * p1 * y + 6.0 * p2 * x
        J[..., 0, 1] = J[..., 1, 0] = 2.0 * x * y * slope + 2.0 * p1 * x + 2.0 * p2 * y
        J[..., 1, 1] = scale + 2.0 * y * y * slope + 6.0 * p1 * y + 2.0 * p2 * x
        return J

    def distort_coefficient_jacobian(self, points: Array) -> Array:
        """(..., 2, m) derivative of `distort` by the coefficients."""
        x, y = points[..., 0], points[..., 1]
        r2 = x * x + y * y
        above, below = self._polynomials(r2)
        up = [r2**n / below for n in (1, 2, 3)]
        down = [-(r2**n) * above / below**2 for n in (1, 2, 3)]
        in_x = [x * up[0], x * up[1], 2.0 * x * y, r2 + 2.0 * x * x, x * up[2], *(x * d for d in down)]
        in_y = [y * up[0], y * up[1], r2 + 2.0 * y * y, 2.0 * x * y, y * up[2], *(y * d for d in down)]
        return np.stack([np.stack(in_x, axis=-1), np.stack(in_y, axis=-1)], axis=-2)

    def radial(self, radius: Array) -> Array:
        """Distorted of (N,) corrected radii."""
        return np.asarray(radius * self._scale(radius * radius)[0])

    @property
    def limit_rad(self) -> float:
        """Where the radial part turns back or has a pole, as an angle; a quarter turn where it never does."""
        k1, k2, _, _, k3, k4, k5, k6 = self.coefficients[:8]
        above, below = np.array([k3, k2, k1, 1.0]), np.array([k6, k5, k4, 1.0])
        u = np.array([1.0, 0.0])  # r²
        # The numerator of d(r N(u) / D(u)) / dr.
        rise = np.polysub(
            np.polymul(np.polyadd(above, 2.0 * np.polymul(u, np.polyder(above))), below),
            2.0 * np.polymul(u, np.polymul(above, np.polyder(below))),
        )
        return float(np.arctan(np.sqrt(min(first_positive_root(np.asarray(rise, float)), first_positive_root(below)))))

    def _polynomials(self, r2: Array) -> tuple[Array, Array]:
        k1, k2, _, _, k3, k4, k5, k6 = self.coefficients[:8]
        return 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3)), 1.0 + r2 * (k4 + r2 * (k5 + r2 * k6))

    def _scale(self, r2: Array) -> tuple[Array, Array]:
        """Radial scale, and its slope by r²."""
        k1, k2, _, _, k3, k4, k5, k6 = self.coefficients[:8]
        above, below = self._polynomials(r2)
        above_slope = k1 + r2 * (2.0 * k2 + r2 * 3.0 * k3)
        below_slope = k4 + r2 * (2.0 * k5 + r2 * 3.0 * k6)
        scale = above / below
        return scale, (above_slope - scale * below_slope) / below
