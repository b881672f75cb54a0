"""The webcam: pinhole with five-coefficient distortion (equations 13 to 16), OpenCV's pixel origin.

The paper writes the projection with row vectors (equation 13); here columns are used, `X_camera = R X_board + t`.
Equation (15) maps corrected to distorted *normalised* coordinates, so its inverse is found numerically.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from armtwin.models.errors import InputError

Array = NDArray[np.float64]

# What a webcam that watches an arm on a table stands off the arm's plane along its view, mm.
_NEAREST_MM = 10.0
_FARTHEST_MM = 1e5
# Newton's method on equation (15) doubles its digits each step; this many reach 1e-13 anywhere in Table 2's picture.
_UNDISTORT_STEPS = 12


@dataclass(frozen=True, eq=False)
class Camera:
    """Intrinsics, distortion and pose of a camera.

    Attributes:
        image_width, image_height: pixels.
        K: (3, 3) camera matrix, pixels.
        D: (5,) plumb-bob coefficients k1, k2, p1, p2, k3.
        R_board_camera: (3, 3) rotation that maps board to camera axes.
        t_board_camera_mm: (3,) the board's origin in the camera frame, mm.

    """

    image_width: int
    image_height: int
    K: Array
    D: Array
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


def distort(points: Array, D: Array) -> Array:
    """Map (N, 2) corrected to distorted normalised coordinates (equation 15)."""
    k1, k2, p1, p2, k3 = D
    x, y = points[..., 0], points[..., 1]
    r2 = x * x + y * y
    radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))
    out = np.empty_like(points)
    out[..., 0] = x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x)
    out[..., 1] = y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y
    return out


def distort_jacobian(points: Array, D: Array) -> Array:
    """(N, 2, 2) derivative of `distort` with respect to its (N, 2) points."""
    k1, k2, p1, p2, k3 = D
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


def undistort(points: Array, D: Array) -> Array:
    """Map (N, 2) distorted to corrected normalised coordinates, the inverse of equation (15), to 1e-10.

    Points beyond the radius at which the polynomial folds back have no inverse; they come back as NaN.
    """
    target = np.asarray(points, dtype=float)
    estimate = target.copy()
    for _ in range(_UNDISTORT_STEPS):
        J = distort_jacobian(estimate, D)
        error = distort(estimate, D) - target
        det = J[..., 0, 0] * J[..., 1, 1] - J[..., 0, 1] * J[..., 1, 0]
        det = np.where(np.abs(det) < 1e-9, 1e-9, det)
        step = np.empty_like(error)
        step[..., 0] = (J[..., 1, 1] * error[..., 0] - J[..., 0, 1] * error[..., 1]) / det
        step[..., 1] = (J[..., 0, 0] * error[..., 1] - J[..., 1, 0] * error[..., 0]) / det
        length = np.linalg.norm(step, axis=-1, keepdims=True)
        estimate = estimate - step * np.minimum(1.0, 0.1 / np.maximum(length, 1e-300))
        if np.all((length < 1e-15) | ~np.isfinite(length)):
            break
    closed = np.abs(distort(estimate, D) - target).max(axis=-1) < 1e-10
    return np.where(closed[..., None], estimate, np.nan)


def project(camera: Camera, points_board_mm: Array) -> Array:
    """Project (N, 3) board points, mm, to (N, 2) raw (distorted) pixels (equations 13 and 15)."""
    X = points_board_mm @ camera.R_board_camera.T + camera.t_board_camera_mm
    return to_pixels(camera, distort(X[..., :2] / X[..., 2:3], camera.D))


def to_pixels(camera: Camera, points: Array) -> Array:
    """Apply the camera matrix to (N, 2) distorted normalised coordinates."""
    return points @ camera.K[:2, :2].T + camera.K[:2, 2]


def normalise(camera: Camera, pixels: Array) -> Array:
    """Return the (N, 2) corrected normalised coordinates of raw pixels."""
    K = camera.K
    distorted = np.empty(np.shape(pixels))
    distorted[..., 1] = (pixels[..., 1] - K[1, 2]) / K[1, 1]
    distorted[..., 0] = (pixels[..., 0] - K[0, 2] - K[0, 1] * distorted[..., 1]) / K[0, 0]
    return undistort(distorted, camera.D)


def back_project(camera: Camera, pixels: Array, plane_z_mm: float) -> Array:
    """Meet the rays of (N, 2) raw pixels with the plane z_board = `plane_z_mm` (equation 16): (N, 3) board mm."""
    xy = normalise(camera, np.asarray(pixels, dtype=float))
    R, t = camera.R_board_camera, camera.t_board_camera_mm
    rays = np.concatenate([xy, np.ones_like(xy[..., :1])], axis=-1) @ R  # directions in board axes
    centre = -R.T @ t
    scale = (plane_z_mm - centre[2]) / rays[..., 2:3]
    points: Array = centre + scale * rays
    return points


def project_jacobian(camera: Camera, points_board_mm: Array) -> Array:
    """(N, 2, 3) derivative of `project` with respect to its board points, pixels per mm."""
    X = points_board_mm @ camera.R_board_camera.T + camera.t_board_camera_mm
    z = X[..., 2]
    xy = X[..., :2] / z[..., None]
    d_xy = np.zeros((*X.shape[:-1], 2, 3))
    d_xy[..., 0, 0] = 1.0 / z
    d_xy[..., 1, 1] = 1.0 / z
    d_xy[..., 0, 2] = -xy[..., 0] / z
    d_xy[..., 1, 2] = -xy[..., 1] / z
    J: Array = camera.K[:2, :2] @ distort_jacobian(xy, camera.D) @ d_xy @ camera.R_board_camera
    return J


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
