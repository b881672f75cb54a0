"""A camera: its pose, its lens and its camera matrix (equations 13 to 16), OpenCV's pixel origin.

The paper writes the projection with row vectors (equation 13); here columns are used, `X_camera = R X_board + t`.
What the lens does to a ray is the lens's own affair (`models/lenses`); the paper's webcam has a plumb bob.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from armtwin.models.errors import InputError
from armtwin.models.lenses.lens import Lens

Array = NDArray[np.float64]

# What a webcam that watches an arm on a table stands off the arm's plane along its view, mm.
_NEAREST_MM = 10.0
_FARTHEST_MM = 1e5


@dataclass(frozen=True, eq=False)
class Camera:
    """Intrinsics, lens and pose of a camera.

    Attributes:
        image_width, image_height: pixels.
        K: (3, 3) camera matrix, pixels.
        lens: what maps rays to places in the image, in focal lengths.
        R_board_camera: (3, 3) rotation that maps board to camera axes.
        t_board_camera_mm: (3,) the board's origin in the camera frame, mm.

    """

    image_width: int
    image_height: int
    K: Array
    lens: Lens
    R_board_camera: Array
    t_board_camera_mm: Array

    @property
    def T_board_camera(self) -> Array:
        """(4, 4) rigid transform that maps board coordinates to the camera frame, mm."""
        T = np.eye(4)
        T[:3, :3] = self.R_board_camera
        T[:3, 3] = self.t_board_camera_mm
        return T

    def moved(self, rotation: Array, translation_mm: Array) -> Camera:
        """Return the camera with `X_camera' = rotation X_camera + translation_mm` (a bump, a tilt, a drift)."""
        return replace(
            self,
            R_board_camera=rotation @ self.R_board_camera,
            t_board_camera_mm=rotation @ self.t_board_camera_mm + translation_mm,
        )


def in_camera(camera: Camera, points_board_mm: Array) -> Array:
    """Return (..., 3) board points in the camera's axes, mm: the rays that a lens takes."""
    X: Array = points_board_mm @ camera.R_board_camera.T + camera.t_board_camera_mm
    return X


def project(camera: Camera, points_board_mm: Array) -> Array:
    """Project (N, 3) board points, mm, to (N, 2) raw (distorted) pixels (equations 13 and 15)."""
    return to_pixels(camera, camera.lens.project(in_camera(camera, points_board_mm)))


def to_pixels(camera: Camera, places: Array) -> Array:
    """Apply the camera matrix to (N, 2) places in the image, focal lengths."""
    return places @ camera.K[:2, :2].T + camera.K[:2, 2]


def rays_of(camera: Camera, pixels: Array) -> Array:
    """Return the (N, 3) rays, camera axes, of (N, 2) raw pixels; Z = 1 for pinhole lenses, unit length for others."""
    K = camera.K
    places = np.empty(np.shape(pixels))
    places[..., 1] = (pixels[..., 1] - K[1, 2]) / K[1, 1]
    places[..., 0] = (pixels[..., 0] - K[0, 2] - K[0, 1] * places[..., 1]) / K[0, 0]
    return camera.lens.unproject(places)


def back_project(camera: Camera, pixels: Array, plane_z_mm: float) -> Array:
    """Meet the rays of (N, 2) raw pixels with the plane z_board = `plane_z_mm` (equation 16): (N, 3) board mm."""
    R, t = camera.R_board_camera, camera.t_board_camera_mm
    rays = rays_of(camera, np.asarray(pixels, dtype=float)) @ R  # directions in board axes
    centre = -R.T @ t
    scale = (plane_z_mm - centre[2]) / rays[..., 2:3]
    points: Array = centre + scale * rays
    return points


def project_jacobian(camera: Camera, points_board_mm: Array) -> Array:
    """(N, 2, 3) derivative of `project` with respect to its board points, pixels per mm."""
    J: Array = camera.K[:2, :2] @ camera.lens.jacobian(in_camera(camera, points_board_mm)) @ camera.R_board_camera
    return J


def corner_angle_rad(camera: Camera) -> float:
    """Angle from the axis, rad, of the farthest corner of the picture; NaN where the lens folds before it."""
    w, h = camera.image_width - 0.5, camera.image_height - 0.5
    rays = rays_of(camera, np.array([[-0.5, -0.5], [w, -0.5], [-0.5, h], [w, h]]))
    return float(np.arctan2(np.linalg.norm(rays[:, :2], axis=1), rays[:, 2]).max())


def check_plane(camera: Camera, arm_plane_z_mm: float) -> None:
    """Raise `InputError` for a plane of the arm, z of the board frame, that the camera does not look at."""
    view = camera.R_board_camera[2]  # the optical axis in the board frame
    eye_z_mm = float(-(camera.R_board_camera.T @ camera.t_board_camera_mm)[2])
    with np.errstate(divide="ignore"):
        distance = float(np.divide(arm_plane_z_mm - eye_z_mm, view[2]))
    if not _NEAREST_MM <= distance <= _FARTHEST_MM:
        way = "greater" if view[2] > 0 else "lesser"
        raise InputError(
            f"arm_plane_z_mm: found {arm_plane_z_mm:g}, which the camera does not look at: it stands at "
            f"z = {eye_z_mm:.4g} mm of the board frame and looks towards {way} z; the plane is wanted "
            f"{_NEAREST_MM:g} to {_FARTHEST_MM:g} mm before it"
        )
