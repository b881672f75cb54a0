"""The equidistant fisheye (Kannala and Brandt 2006): ROS's `equidistant`, OpenCV's `cv2.fisheye`, Kalibr's.

A ray at the angle θ from the axis lands θ (1 + k1 θ² + k2 θ⁴ + k3 θ⁶ + k4 θ⁸) focal lengths from the principal point,
also where θ is a quarter turn or more.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from armtwin.models.lenses.lens import Lens
from armtwin.models.lenses.pinhole import first_positive_root

Array = NDArray[np.float64]

_POWERS = np.array([2, 4, 6, 8])
# Halvings that leave 1e-9 rad of half a turn, which Newton's steps then finish.
_HALVINGS, _STEPS = 32, 4
_CLOSED = 1e-10
# Below this angle sin θ / θ is 1 to the last digit.
_ON_AXIS = 1e-9


class Equidistant(Lens):
    """Four radial coefficients over the angle from the axis."""

    model = "equidistant"
    names = ("k1", "k2", "k3", "k4")

    def project(self, rays: Array) -> Array:
        """Map (..., 3) rays to (..., 2) places in the image, focal lengths."""
        across, theta = _polar(rays)
        scale = np.where(across > 0.0, self._radius(theta) / np.maximum(across, 1e-300), 1.0 / rays[..., 2])
        return np.asarray(rays[..., :2] * scale[..., None])

    def unproject(self, places: Array) -> Array:
        """Map (..., 2) places in the image to (..., 3) rays of unit length; NaN beyond the fold."""
        target = np.asarray(places, dtype=float)
        radius = np.linalg.norm(target, axis=-1)
        low, high = np.zeros_like(radius), np.full_like(radius, self.limit_rad)
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            short = self._radius(middle) < radius
            low, high = np.where(short, middle, low), np.where(short, high, middle)
        theta = 0.5 * (low + high)
        for _ in range(_STEPS):
            theta = theta - (self._radius(theta) - radius) / np.maximum(self._slope(theta), 1e-9)
        closed = np.abs(self._radius(theta) - radius) < _CLOSED
        with np.errstate(invalid="ignore"):
            along = np.where(radius[..., None] > _ON_AXIS, target / np.maximum(radius, 1e-300)[..., None], target)
        sine = np.where(radius > _ON_AXIS, np.sin(theta), 1.0)
        rays = np.concatenate([along * sine[..., None], np.cos(theta)[..., None]], axis=-1)
        return np.where(closed[..., None], rays, np.nan)

    def jacobian(self, rays: Array) -> Array:
        """(..., 2, 3) derivative of `project` by its rays."""
        across, theta = _polar(rays)
        z = rays[..., 2]
        length2 = across**2 + z**2
        near_axis = across < _ON_AXIS * np.abs(z)
        safe = np.where(near_axis, 1.0, across)
        radius, slope = self._radius(theta), self._slope(theta)
        e = np.where(near_axis[..., None], 0.0, rays[..., :2] / safe[..., None])
        # Along the radius the angle grows by z / length² a unit; around the axis the picture turns by radius / across.
        around = np.where(near_axis, 1.0 / z, radius / safe)
        outward = np.where(near_axis, 1.0 / z, slope * z / length2)
        J = np.empty((*rays.shape[:-1], 2, 3))
        ee = e[..., :, None] * e[..., None, :]
        J[..., :2] = around[..., None, None] * np.eye(2) + (outward - around)[..., None, None] * ee
        J[..., 2] = e * (-slope * across / length2)[..., None]
        return J

    def coefficient_jacobian(self, rays: Array) -> Array:
        """(..., 2, 4) derivative of `project` by the coefficients."""
        across, theta = _polar(rays)
        e = rays[..., :2] / np.maximum(across, 1e-300)[..., None]
        return np.asarray(e[..., :, None] * (theta[..., None] ** (_POWERS + 1))[..., None, :])

    @property
    def limit_rad(self) -> float:
        """Where the radius over θ turns back, half a turn at most."""
        rise = np.zeros(9)
        rise[::2] = [*(self.coefficients * (_POWERS + 1))[::-1], 1.0]
        return min(first_positive_root(rise), float(np.pi))

    def _radius(self, theta: Array) -> Array:
        k1, k2, k3, k4 = self.coefficients
        t2 = theta * theta
        return np.asarray(theta * (1.0 + t2 * (k1 + t2 * (k2 + t2 * (k3 + t2 * k4)))))

    def _slope(self, theta: Array) -> Array:
        k1, k2, k3, k4 = self.coefficients
        t2 = theta * theta
        return np.asarray(1.0 + t2 * (3.0 * k1 + t2 * (5.0 * k2 + t2 * (7.0 * k3 + t2 * 9.0 * k4))))


def _polar(rays: Array) -> tuple[Array, Array]:
    """Distance of rays' ends from the axis, and their angle from it, rad."""
    across = np.hypot(rays[..., 0], rays[..., 1])
    return across, np.arctan2(across, rays[..., 2])
