"""The thin-prism model, without and with a tilted sensor (OpenCV's `CALIB_THIN_PRISM_MODEL`, `CALIB_TILTED_MODEL`).

A lens element or a sensor that stands askew shifts the picture by s r² + s' r⁴ (Weng, Cohen and Herniou 1992); a sensor
tilted against the lens on purpose (Scheimpflug) is a homography besides.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from armtwin.models.lenses.rational import Rational

Array = NDArray[np.float64]


class ThinPrism(Rational):
    """The rational model and four coefficients of a thin prism."""

    model = "thin_prism"
    names = (*Rational.names, "s1", "s2", "s3", "s4")

    @property
    def ros_model(self) -> str:
        """ROS has no name of its own for it: the number of coefficients tells, as in OpenCV."""
        return Rational.model

    def distort(self, points: Array) -> Array:
        """Map (..., 2) corrected to distorted normalised coordinates."""
        s1, s2, s3, s4 = self.coefficients[8:12]
        r2 = np.sum(points * points, axis=-1)
        return super().distort(points) + np.stack([r2 * (s1 + r2 * s2), r2 * (s3 + r2 * s4)], axis=-1)

    def distort_jacobian(self, points: Array) -> Array:
        """(..., 2, 2) derivative of `distort` by its points."""
        s1, s2, s3, s4 = self.coefficients[8:12]
        r2 = np.sum(points * points, axis=-1)
        slopes = np.stack([s1 + 2.0 * r2 * s2, s3 + 2.0 * r2 * s4], axis=-1)  # by r²
        return np.asarray(super().distort_jacobian(points) + slopes[..., :, None] * 2.0 * points[..., None, :])

    def distort_coefficient_jacobian(self, points: Array) -> Array:
        """(..., 2, m) derivative of `distort` by the coefficients."""
        r2 = np.sum(points * points, axis=-1)
        prism = np.zeros((*r2.shape, 2, 4))
        prism[..., 0, 0], prism[..., 0, 1] = r2, r2 * r2
        prism[..., 1, 2], prism[..., 1, 3] = r2, r2 * r2
        return np.concatenate([super().distort_coefficient_jacobian(points), prism], axis=-1)


class TiltedThinPrism(ThinPrism):
    """The thin-prism model and two angles, rad, by which the sensor is tilted."""

    model = "thin_prism_tilted"
    names = (*ThinPrism.names, "tau_x", "tau_y")

    @property
    def sensor(self) -> Array:
        """(3, 3) homography from the upright to the tilted sensor (OpenCV's `computeTiltProjectionMatrix`)."""
        turn_x, turn_y = self._turns()
        return _onto_sensor(turn_y @ turn_x)

    def distort(self, points: Array) -> Array:
        """Map (..., 2) corrected to distorted normalised coordinates."""
        moved = _homogeneous(super().distort(points)) @ self.sensor.T
        return np.asarray(moved[..., :2] / moved[..., 2:3])

    def distort_jacobian(self, points: Array) -> Array:
        """(..., 2, 2) derivative of `distort` by its points."""
        return np.asarray(self._sensor_jacobian(super().distort(points)) @ super().distort_jacobian(points))

    def distort_coefficient_jacobian(self, points: Array) -> Array:
        """(..., 2, m) derivative of `distort` by the coefficients."""
        upright = super().distort(points)
        before = self._sensor_jacobian(upright) @ super().distort_coefficient_jacobian(points)
        moved = _homogeneous(upright) @ self.sensor.T
        tilts = []
        for change in self._sensor_slopes():
            d = _homogeneous(upright) @ change.T
            tilts.append((d[..., :2] - moved[..., :2] / moved[..., 2:3] * d[..., 2:3]) / moved[..., 2:3])
        return np.concatenate([before, np.stack(tilts, axis=-1)], axis=-1)

    def _sensor_jacobian(self, upright: Array) -> Array:
        S = self.sensor
        moved = _homogeneous(upright) @ S.T
        place = moved[..., :2] / moved[..., 2:3]
        return np.asarray((S[:2, :2] - place[..., :, None] * S[2, :2]) / moved[..., 2:3, None])

    def _turns(self) -> tuple[Array, Array]:
        tau_x, tau_y = self.coefficients[12:14]
        cx, sx, cy, sy = np.cos(tau_x), np.sin(tau_x), np.cos(tau_y), np.sin(tau_y)
        turn_x = np.array([[1.0, 0.0, 0.0], [0.0, cx, sx], [0.0, -sx, cx]])
        turn_y = np.array([[cy, 0.0, -sy], [0.0, 1.0, 0.0], [sy, 0.0, cy]])
        return turn_x, turn_y

    def _sensor_slopes(self) -> tuple[Array, Array]:
        """(3, 3) derivatives of `sensor` by tau_x and tau_y."""
        turn_x, turn_y = self._turns()
        about_x = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
        about_y = np.array([[0.0, 0.0, -1.0], [0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
        R = turn_y @ turn_x
        slopes = [turn_y @ about_x @ turn_x, about_y @ R]
        by_x, by_y = (_lever(R) @ dR + (_lever(dR) - np.diag([0.0, 0.0, 1.0])) @ R for dR in slopes)
        return by_x, by_y


def _lever(R: Array) -> Array:
    return np.array([[R[2, 2], 0.0, -R[0, 2]], [0.0, R[2, 2], -R[1, 2]], [0.0, 0.0, 1.0]])


def _onto_sensor(R: Array) -> Array:
    S: Array = _lever(R) @ R
    return S


def _homogeneous(points: Array) -> Array:
    return np.concatenate([points, np.ones_like(points[..., :1])], axis=-1)
