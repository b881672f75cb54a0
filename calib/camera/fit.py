"""Calibrate a camera from views of a board, with how far to trust it: covariance, views, coverage, advice."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from armtwin.calib.camera.advice import Advice, advise, tilts
from armtwin.calib.camera.bundle import residuals_of
from armtwin.calib.camera.corners import Corners
from armtwin.calib.camera.coverage import Coverage, cover
from armtwin.calib.camera.models import USUAL, CameraModel
from armtwin.calib.camera.start import fit_model, undetermined
from armtwin.calib.camera.target import Target
from armtwin.calib.camera.uncertainty import Uncertainty, uncertainty
from armtwin.models.camera import Camera
from armtwin.models.errors import InputError

Array = NDArray[np.float64]

# Zhang's method needs two tilted views for a camera without skew, three in general.
MIN_VIEWS = 3
# A focal length less certain than this share of itself means that the views do not determine it.
_MAX_FOCAL_STD = 0.2
# Boards whose normals differ by less all tilt alike: a hand that holds still shakes by two or three degrees.
_LEAST_TURN_RAD = np.radians(5.0)


@dataclass(frozen=True, eq=False)
class CameraCalibration:
    """A calibrated camera and how far it can be trusted.

    Attributes:
        camera: intrinsics, distortion, and the pose of the board in the reference view.
        board: what was photographed.
        model: which lens was fitted, and what beside it.
        bow_mm: (2,) height of the board's middle over its edges along x and y; zero where it was taken for flat.
        views: the corners used; turned together by half a turn where Table 2's frame wants it.
        reference: index of the reference view.
        rms_px: root mean square distance of measured and predicted corners.
        residuals_px: for each view (N, 2) measured less predicted corners.
        poses: (V, 6) rotation vectors and translations (mm) of the board, board to camera.
        uncertainty: standard deviations, covariance and the influence of each view.
        coverage: how much of the image the corners cover.
        advice: views to drop and to add.

    """

    camera: Camera
    board: Target
    model: CameraModel
    bow_mm: Array
    views: tuple[Corners, ...]
    reference: int
    rms_px: float
    residuals_px: tuple[Array, ...]
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
        """Value of each intrinsic parameter, by its name."""
        K = self.camera.K
        return {"fx": K[0, 0], "fy": K[1, 1], "cx": K[0, 2], "cy": K[1, 2], **self.camera.lens.named}

    @property
    def std(self) -> dict[str, float]:
        """Standard deviation of each adjusted intrinsic, if all corners err independently and alike."""
        return dict(zip(self.uncertainty.names, self.uncertainty.std.tolist(), strict=True))

    @property
    def total_std(self) -> dict[str, float]:
        """Standard deviation of each adjusted intrinsic to believe: with views or parts of the image wrong together."""
        return dict(zip(self.uncertainty.names, self.uncertainty.total_std.tolist(), strict=True))

    @property
    def jackknife_std(self) -> dict[str, float]:
        """Standard deviation of each adjusted intrinsic from leaving out views, with no such assumption."""
        return dict(zip(self.uncertainty.names, self.uncertainty.jackknife_std.tolist(), strict=True))


def calibrate_camera(
    views: Sequence[Corners],
    board: Target,
    image_size: tuple[int, int],
    reference: int = 0,
    model: CameraModel = USUAL,
) -> CameraCalibration:
    """Fit the camera to the corners of at least three views.

    `image_size` is (width, height), pixels. The camera's pose is that of the board in view number `reference`, in
    Table 2's frame: all views are turned by half a turn where needed so that the board's y axis points up in that
    view's picture (x then points left, z away from the camera, for a board that hangs upright).

    Raises:
        InputError: too few views, a view of another board, or views that do not determine the camera.

    """
    _check(views, board, image_size, reference)
    board, views = upright(views, board, reference)
    points, pixels = [board.points_of(view) for view in views], [view.pixels for view in views]
    bundle = fit_model(model, points, pixels, board, image_size)
    residuals = residuals_of(bundle, points, pixels)
    try:
        spread = uncertainty(bundle, points, pixels, model.free, image_size)
    except np.linalg.LinAlgError as error:
        raise undetermined() from error
    if not np.all(np.isfinite(spread.std)) or spread.total_std[0] > _MAX_FOCAL_STD * bundle.K[0, 0]:
        raise undetermined()
    rotations = rotations_of(bundle.poses)
    check_turns(rotations)
    coverage = cover(np.concatenate(pixels), image_size)
    return CameraCalibration(
        camera=Camera(*image_size, bundle.K, bundle.lens, rotations[reference], bundle.poses[reference, 3:]),
        board=board,
        model=model,
        bow_mm=bundle.bow_mm,
        views=tuple(views),
        reference=reference,
        rms_px=rms_px(residuals),
        residuals_px=tuple(residuals),
        poses=bundle.poses,
        uncertainty=spread,
        coverage=coverage,
        advice=advise([view.name for view in views], view_rms_px(residuals), rotations, coverage),
    )


def rms_px(residuals_px: Sequence[Array]) -> float:
    """Root mean square distance over all views of (N, 2) residuals each."""
    return float(np.sqrt(np.mean(np.concatenate([np.sum(r**2, axis=-1) for r in residuals_px]))))


def view_rms_px(residuals_px: Sequence[Array]) -> Array:
    """(V,) root mean square distance of each view's (N, 2) residuals."""
    return np.array([np.sqrt(np.mean(np.sum(r**2, axis=-1))) for r in residuals_px])


def rotations_of(poses: Array) -> Array:
    """(V, 3, 3) rotation matrices from (V, 6) poses."""
    return np.array([cv2.Rodrigues(pose[:3])[0] for pose in poses], dtype=np.float64)


def upright(views: Sequence[Corners], board: Target, reference: int) -> tuple[Target, list[Corners]]:
    """Turn board and views by half a turn where the board's y axis points down in the reference view."""
    if board.y_down_px(views[reference]) <= 0:
        return board, list(views)
    return board.half_turned(views)


def check_turns(rotations: Array) -> None:
    """Refuse (V, 3, 3) rotations of a board that was held still, or only shifted and rolled: no focal length in them.

    Raises:
        InputError: says how to move the board.

    """
    normals = rotations[:, :, 2]
    turned = float(np.arccos(np.clip(normals @ normals.T, -1.0, 1.0)).max())
    if turned < _LEAST_TURN_RAD:
        raise InputError(
            f"camera calibration: the board is tilted alike in all {len(rotations)} views (to "
            f"{np.degrees(turned):.1f} degrees), which tells no focal length from a distance; turn the board between "
            "photographs: its left, right, top and bottom side each 30 to 45 degrees towards the camera"
        )


def _check(views: Sequence[Corners], board: Target, image_size: tuple[int, int], reference: int) -> None:
    if len(views) < MIN_VIEWS:
        raise InputError(
            f"camera calibration: found {len(views)} usable views, wanted at least {MIN_VIEWS}, better 10 to 20; "
            "photograph the board from more sides"
        )
    if not 0 <= reference < len(views):
        raise InputError(f"reference view: found {reference}, wanted a number from 0 to {len(views) - 1}")
    width, height = image_size
    for view in views:
        if view.ids is None and view.pixels.shape != (board.n_corners, 2):
            raise InputError(f"{view.name}: found {len(view.pixels)} corners, wanted {board.n_corners} ({board})")
        low, high = view.pixels.min(axis=0), view.pixels.max(axis=0)
        if not (np.all(low > -1) and high[0] < width and high[1] < height):  # a NaN fails, too
            raise InputError(
                f"{view.name}: found a corner that is missing or outside the picture of {width}x{height} px"
            )
