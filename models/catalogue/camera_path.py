"""A camera whose pose, focal length or lens differ from what was assumed, for all of a recording or along it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from armtwin.models.camera import Camera, in_camera, to_pixels

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class CameraPath:
    """Departures from the assumed camera; each is broadcast over the samples.

    Attributes:
        rotation_rad: (N or 1, 3) rotation vector in the camera's axes, applied after the assumed pose.
        translation_mm: (N or 1, 3) shift in the camera's axes.
        focal_scale: (N or 1,) true focal length over the assumed one.
        distortion: (m or 1,) change of the lens's coefficients.

    """

    rotation_rad: Array
    translation_mm: Array
    focal_scale: Array
    distortion: Array

    @classmethod
    def as_assumed(cls) -> CameraPath:
        """Return the camera as it was assumed."""
        return cls(np.zeros((1, 3)), np.zeros((1, 3)), np.ones(1), np.zeros(1))

    def turned(self, rotation_rad: Array, translation_mm: Array) -> CameraPath:
        """Add (N or 1, 3) rotations and shifts (small, so that their order does not matter)."""
        return replace(
            self,
            rotation_rad=self.rotation_rad + rotation_rad,
            translation_mm=self.translation_mm + translation_mm,
        )

    def zoomed(self, scale: Array) -> CameraPath:
        """Multiply the focal length by (N or 1,) scales."""
        return replace(self, focal_scale=self.focal_scale * scale)

    def distorted(self, change: Array) -> CameraPath:
        """Add (m,) to the lens's coefficients."""
        return replace(self, distortion=self.distortion + change)

    def project(self, camera: Camera, points_board_mm: Array) -> Array:
        """Project (N, M, 3) board points, mm, to (N, M, 2) raw pixels."""
        lens = camera.lens.changed(self.distortion)
        return to_pixels(camera, lens.project(self._before_camera(camera, points_board_mm)) * self._scale)

    def slopes(self, camera: Camera, points_board_mm: Array, directions: Array) -> Array:
        """(k, N, M, 2) pixels per mm by which (N, M, 3) board points move along (k, 3) board directions."""
        lens = camera.lens.changed(self.distortion)
        J = camera.K[:2, :2] @ lens.jacobian(self._before_camera(camera, points_board_mm))
        along = _rotate((directions @ camera.R_board_camera.T)[:, None, None, :], self.rotation_rad[:, None, :])
        return np.asarray((J @ along[..., None])[..., 0] * self._scale)

    @property
    def _scale(self) -> Array:
        return self.focal_scale[:, None, None]

    def _before_camera(self, camera: Camera, points_board_mm: Array) -> Array:
        """(N, M, 3) board points in the camera's axes, mm."""
        X = in_camera(camera, points_board_mm)
        if self.rotation_rad.any() or self.translation_mm.any():
            X = _rotate(X, self.rotation_rad[:, None, :]) + self.translation_mm[:, None, :]
        return X


def _rotate(X: Array, rotation: Array) -> Array:
    """Rotate X (N, M, 3) by rotation vectors (N or 1, 1, 3) (Rodrigues)."""
    angle = np.linalg.norm(rotation, axis=-1, keepdims=True)
    sine = np.sinc(angle / np.pi)
    versine = 0.5 * np.sinc(angle / (2 * np.pi)) ** 2
    cross = np.cross(rotation, X)
    out: Array = X + sine * cross + versine * np.cross(rotation, cross)
    return out
