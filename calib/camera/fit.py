"""Calibrate a camera from views of a chessboard: Zhang's method, then least squares over all corners.

The fit is OpenCV's (Zhang 2000, A flexible new technique for camera calibration); this module adds what it does not
tell: the full covariance, the influence of each view, the coverage and advice on views to drop or to add.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from armtwin.calib.camera.advice import Advice, advise, tilts
from armtwin.calib.camera.board import Board
from armtwin.calib.camera.corners import Corners, y_down_px
from armtwin.calib.camera.coverage import Coverage, cover
from armtwin.calib.camera.uncertainty import INTRINSICS, Uncertainty, uncertainty
from armtwin.models.camera import Camera
from armtwin.models.errors import InputError
from armtwin.models.lenses import PlumbBob

Array = NDArray[np.float64]

# Zhang's method needs two tilted views for a camera without skew, three in general.
MIN_VIEWS = 3
# OpenCV's own limit (30 steps) stops some fits of few views early.
_CRITERIA = (cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS, 200, 1e-12)
# A focal length less certain than this share of itself means that the views do not determine it.
_MAX_FOCAL_STD = 0.2


@dataclass(frozen=True, eq=False)
class CameraCalibration:
    """A calibrated camera and how far it can be trusted.

    Attributes:
        camera: intrinsics, distortion, and the pose of the board in the reference view.
        board: the chessboard.
        views: the corners used; turned together by half a turn where Table 2's frame wants it.
        reference: index of the reference view.
        rms_px: root mean square distance of measured and predicted corners.
        residuals_px: (V, N, 2) measured less predicted corners.
        poses: (V, 6) rotation vectors and translations (mm) of the board, board to camera.
        uncertainty: standard deviations, covariance and the influence of each view.
        coverage: how much of the image the corners cover.
        advice: views to drop and to add.

    """

    camera: Camera
    board: Board
    views: tuple[Corners, ...]
    reference: int
    rms_px: float
    residuals_px: Array
    poses: Array
    uncertainty: Uncertainty
    coverage: Coverage
    advice: Advice

    @property
    def per_view_rms_px(self) -> Array:
        """(V,) root mean square distance of measured and predicted corners in each view."""
        return view_rms_px(self.residuals_px)

    @property
    def tilt_deg(self) -> Array:
        """(V,) angle of the board against the image plane in each view, degrees, for people."""
        return np.rad2deg(np.linalg.norm(tilts(rotations_of(self.poses)), axis=1))

    @property
    def intrinsics(self) -> dict[str, float]:
        """Value of each intrinsic parameter, named as in `INTRINSICS`."""
        K = self.camera.K
        return {"fx": K[0, 0], "fy": K[1, 1], "cx": K[0, 2], "cy": K[1, 2], **self.camera.lens.named}

    @property
    def std(self) -> dict[str, float]:
        """Standard deviation of each intrinsic parameter, if all corners err independently and alike."""
        return dict(zip(INTRINSICS, self.uncertainty.std.tolist(), strict=True))

    @property
    def jackknife_std(self) -> dict[str, float]:
        """Standard deviation of each intrinsic parameter from leaving out views, with no such assumption."""
        return dict(zip(INTRINSICS, self.uncertainty.jackknife_std.tolist(), strict=True))

    @property
    def covariance(self) -> Array:
        """(9, 9) covariance in the order of `INTRINSICS`."""
        return self.uncertainty.covariance


def calibrate_camera(
    views: Sequence[Corners], board: Board, image_size: tuple[int, int], reference: int = 0
) -> CameraCalibration:
    """Fit the camera to the corners of at least three views.

    `image_size` is (width, height), pixels. The camera's pose is that of the board in view number `reference`, in
    Table 2's frame: all views are turned by half a turn where needed so that the board's y axis points up in that
    view's picture (x then points left, z away from the camera, for a board that hangs upright).

    Raises:
        InputError: too few views, a view of another board, or views that do not determine the camera.

    """
    _check(views, board, image_size, reference)
    views = _upright(views, board, reference)
    points = board.points_mm
    K, D, poses = _fit(points, views, image_size)
    residuals = np.stack([view.pixels - _project(points, pose, K, D) for view, pose in zip(views, poses, strict=True)])
    try:
        spread = uncertainty(points, residuals, poses, K, D)
    except np.linalg.LinAlgError as error:
        raise _undetermined() from error
    if not np.all(np.isfinite(spread.std)) or spread.std[0] > _MAX_FOCAL_STD * K[0, 0]:
        raise _undetermined()
    rotations = rotations_of(poses)
    coverage = cover(np.concatenate([view.pixels for view in views]), image_size)
    return CameraCalibration(
        camera=Camera(*image_size, K, PlumbBob(D), rotations[reference], poses[reference, 3:]),
        board=board,
        views=tuple(views),
        reference=reference,
        rms_px=float(np.sqrt(np.mean(np.sum(residuals**2, axis=-1)))),
        residuals_px=residuals,
        poses=poses,
        uncertainty=spread,
        coverage=coverage,
        advice=advise([view.name for view in views], view_rms_px(residuals), rotations, coverage),
    )


def view_rms_px(residuals_px: Array) -> Array:
    """(V,) root mean square distance from (V, N, 2) residuals."""
    return np.sqrt(np.mean(np.sum(residuals_px**2, axis=-1), axis=-1))


def rotations_of(poses: Array) -> Array:
    """(V, 3, 3) rotation matrices from (V, 6) poses."""
    return np.array([cv2.Rodrigues(pose[:3])[0] for pose in poses], dtype=np.float64)


def _fit(points: Array, views: Sequence[Corners], image_size: tuple[int, int]) -> tuple[Array, Array, Array]:
    """K (3, 3), D (5,) and poses (V, 6) of least squared distance."""
    object_points = [points.astype(np.float32)] * len(views)
    image_points = [view.pixels.astype(np.float32) for view in views]
    try:
        _, K, D, turns, moves = cv2.calibrateCamera(
            object_points, image_points, image_size, np.eye(3), np.zeros(5), criteria=_CRITERIA
        )
    except cv2.error as error:
        raise _undetermined() from error
    if not (np.all(np.isfinite(K)) and np.all(np.isfinite(D))):
        raise _undetermined()
    poses: Array = np.hstack([np.reshape(turns, (-1, 3)), np.reshape(moves, (-1, 3))]).astype(np.float64)
    return np.asarray(K, np.float64), np.asarray(D, np.float64).ravel()[:5], poses


def _project(points: Array, pose: Array, K: Array, D: Array) -> Array:
    pixels, _ = cv2.projectPoints(points, pose[:3], pose[3:], K, D)
    return np.asarray(pixels, dtype=float).reshape(-1, 2)


def _upright(views: Sequence[Corners], board: Board, reference: int) -> list[Corners]:
    """Turn all views by half a turn where the board's y axis points down in the reference view."""
    grid = views[reference].pixels.reshape(board.rows, board.columns, 2)
    step = -1 if y_down_px(grid) > 0 else 1
    return [Corners(view.name, view.pixels[::step]) for view in views]


def _check(views: Sequence[Corners], board: Board, image_size: tuple[int, int], reference: int) -> None:
    if len(views) < MIN_VIEWS:
        raise InputError(
            f"camera calibration: found {len(views)} usable views, wanted at least {MIN_VIEWS}, better 10 to 20; "
            "photograph the board from more sides"
        )
    if not 0 <= reference < len(views):
        raise InputError(f"reference view: found {reference}, wanted a number from 0 to {len(views) - 1}")
    width, height = image_size
    for view in views:
        if view.pixels.shape != (board.n_corners, 2):
            raise InputError(f"{view.name}: found {len(view.pixels)} corners, wanted {board.n_corners} ({board})")
        low, high = view.pixels.min(axis=0), view.pixels.max(axis=0)
        if not (np.all(low > -1) and high[0] < width and high[1] < height):  # a NaN fails, too
            raise InputError(
                f"{view.name}: found a corner that is missing or outside the picture of {width}x{height} px"
            )


def _undetermined() -> InputError:
    return InputError(
        "camera calibration: the views do not determine the camera, wanted the board at different tilts (about 30 to "
        "45 degrees to all four sides) and distances; found views too much alike"
    )
