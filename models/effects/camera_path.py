"""A camera whose pose, focal length or lens differ from what was assumed, for all of a recording or along it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from models.camera import Camera, distort, to_pixels

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class CameraPath:
    """Departures from the assumed camera; each is broadcast over the samples.

    Attributes:
        rotation_rad: (N or 1, 3) rotation vector in the camera's axes, applied after the assumed pose.
        translation_mm: (N or 1, 3) shift in the camera's axes.
        focal_scale: (N or 1,) true focal length over the assumed one.
        distortion: (5,) change of k1, k2, p1, p2, k3.

    """

    rotation_rad: Array
    translation_mm: Array
    focal_scale: Array
    distortion: Array

    @classmethod
    def as_assumed(cls) -> CameraPath:
        """Return the camera as it was assumed."""
        return cls(np.zeros((1, 3)), np.zeros((1, 3)), np.ones(1), np.zeros(5))

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
        """Add (5,) to the distortion coefficients."""
        return replace(self, distortion=self.distortion + change)

    def project(self, camera: Camera, points_board_mm: Array) -> Array:
        """Project (N, M, 3) board points, mm, to (N, M, 2) raw pixels."""
        X = points_board_mm @ camera.R_board_camera.T + camera.t_board_camera_mm
        if self.rotation_rad.any() or self.translation_mm.any():
            X = _rotate(X, self.rotation_rad[:, None, :]) + self.translation_mm[:, None, :]
        xy = distort(X[..., :2] / X[..., 2:3], camera.D + self.distortion)
        if np.any(self.focal_scale != 1.0):
            xy = xy * self.focal_scale[:, None, None]
        return to_pixels(camera, xy)


def _rotate(X: Array, rotation: Array) -> Array:
    """Rotate X (N, M, 3) by rotation vectors (N or 1, 1, 3) (Rodrigues)."""
    angle = np.linalg.norm(rotation, axis=-1, keepdims=True)
    sine = np.sinc(angle / np.pi)
    versine = 0.5 * np.sinc(angle / (2 * np.pi)) ** 2
    cross = np.cross(rotation, X)
    out: Array = X + sine * cross + versine * np.cross(rotation, cross)
    return out
