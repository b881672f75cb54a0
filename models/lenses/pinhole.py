"""Lenses that see half of all rays at most: a perspective picture, then a distortion of it."""

from __future__ import annotations

from abc import abstractmethod

import numpy as np
from numpy.typing import NDArray

from armtwin.models.lenses.lens import Lens

Array = NDArray[np.float64]

# Newton's method doubles its digits each step; this many reach 1e-13 anywhere in Table 2's picture.
_STEPS = 12
_CLOSED = 1e-10
# Halvings of a quarter turn that leave less than 1e-12 rad.
_HALVINGS = 42


class PinholeLens(Lens):
    """A lens that distorts *corrected normalised* coordinates (x, y) = (X / Z, Y / Z)."""

    @abstractmethod
    def distort(self, points: Array) -> Array:
        """Map (..., 2) corrected to distorted normalised coordinates."""

    @abstractmethod
    def distort_jacobian(self, points: Array) -> Array:
        """(..., 2, 2) derivative of `distort` by its points."""

    @abstractmethod
    def distort_coefficient_jacobian(self, points: Array) -> Array:
        """(..., 2, m) derivative of `distort` by the coefficients."""

    @abstractmethod
    def radial(self, radius: Array) -> Array:
        """Distorted of (N,) corrected radii, by the radial part of the model alone."""

    def project(self, rays: Array) -> Array:
        """Map (..., 3) rays to (..., 2) distorted normalised coordinates."""
        return self.distort(rays[..., :2] / rays[..., 2:3])

    def unproject(self, places: Array) -> Array:
        """Map (..., 2) distorted normalised coordinates to (..., 3) rays with Z = 1; NaN beyond the fold."""
        xy = self.undistort(places)
        return np.concatenate([xy, np.where(np.isnan(xy[..., :1]), np.nan, 1.0)], axis=-1)

    def jacobian(self, rays: Array) -> Array:
        """(..., 2, 3) derivative of `project` by its rays."""
        z = rays[..., 2:3]
        xy = rays[..., :2] / z
        by_place = self.distort_jacobian(xy) / z[..., None]
        J = np.empty((*rays.shape[:-1], 2, 3))
        J[..., :2] = by_place
        J[..., 2] = -(by_place[..., 0] * xy[..., 0:1] + by_place[..., 1] * xy[..., 1:2])
        return J

    def coefficient_jacobian(self, rays: Array) -> Array:
        """(..., 2, m) derivative of `project` by the coefficients."""
        return self.distort_coefficient_jacobian(rays[..., :2] / rays[..., 2:3])

    def undistort(self, places: Array) -> Array:
        """Map (..., 2) distorted to corrected normalised coordinates, the inverse of `distort`, to 1e-10.

        Newton's method from the place itself, which serves narrow pictures; where it does not close, once more from
        the radius that the radial part alone gives. Places beyond the radius at which the model folds back have no
        inverse; they come back as NaN.
        """
        target = np.asarray(places, dtype=float)
        found = self._newton(target, target.copy())
        left = ~np.isfinite(found).all(axis=-1) & np.isfinite(target).all(axis=-1)
        if left.any():
            again = self._newton(target[left], self._radially(target[left]))
            beyond = np.arctan(np.linalg.norm(again, axis=-1)) > self.limit_rad
            found[left] = np.where(beyond[..., None], np.nan, again)
        return found

    def _newton(self, target: Array, estimate: Array) -> Array:
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            for _ in range(_STEPS):
                J = self.distort_jacobian(estimate)
                error = self.distort(estimate) - target
                det = J[..., 0, 0] * J[..., 1, 1] - J[..., 0, 1] * J[..., 1, 0]
                det = np.where(np.abs(det) < 1e-9, 1e-9, det)
                step = np.empty_like(error)
                step[..., 0] = (J[..., 1, 1] * error[..., 0] - J[..., 0, 1] * error[..., 1]) / det
                step[..., 1] = (J[..., 0, 0] * error[..., 1] - J[..., 1, 0] * error[..., 0]) / det
                length = np.linalg.norm(step, axis=-1, keepdims=True)
                estimate = estimate - step * np.minimum(1.0, 0.1 / np.maximum(length, 1e-300))
                if np.all((length < 1e-15) | ~np.isfinite(length)):
                    break
            closed = np.abs(self.distort(estimate) - target).max(axis=-1) < _CLOSED
        return np.where(closed[..., None], estimate, np.nan)

    def _radially(self, target: Array) -> Array:
        """(N, 2) points whose radial distortion alone gives the targets' radii, by halving the angle."""
        wanted = np.linalg.norm(target, axis=-1)
        low, high = np.zeros(len(target)), np.full(len(target), min(self.limit_rad, 0.5 * np.pi - 1e-6))
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            short = self.radial(np.tan(middle)) < wanted
            low, high = np.where(short, middle, low), np.where(short, high, middle)
        return target * (np.tan(low) / np.maximum(wanted, 1e-300))[:, None]


def first_positive_root(polynomial: Array) -> float:
    """Return the least positive real root of a polynomial, highest power first; infinite where there is none."""
    roots = np.roots(polynomial)
    real = roots[(np.abs(roots.imag) < 1e-12) & (roots.real > 0.0)].real
    return float(real.min()) if real.size else float("inf")
