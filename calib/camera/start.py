"""The fit of one camera model: where each kind of lens starts from, then bundle adjustment.

The usual model is fitted by OpenCV (Zhang 2000, A flexible new technique for camera calibration). The pinhole lenses
with more coefficients start from there; a fisheye starts from the focal length of a few that places the boards best.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from armtwin.calib.camera.bundle import Bundle, adjust, place_view, residuals_of
from armtwin.calib.camera.models import USUAL, CameraModel
from armtwin.calib.camera.target import Target
from armtwin.models.errors import InputError
from armtwin.models.lenses import Equidistant, Lens, PlumbBob

Array = NDArray[np.float64]

# OpenCV's own limit (30 steps) stops some fits of few views early.
_CRITERIA = (cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS, 200, 1e-12)
# Focal lengths that a fisheye is tried with, as shares of half the picture's diagonal: 100, 65, 40 and 20 degrees from
# the axis to the corners.
_FOCALS = (1.0 / np.radians(100.0), 1.0 / np.radians(65.0), 1.0 / np.radians(40.0), 1.0 / np.radians(20.0))


def fit_model(
    model: CameraModel, points: Sequence[Array], pixels: Sequence[Array], board: Target, image_size: tuple[int, int]
) -> Bundle:
    """Fit a model to the (N, 3) board points, mm, and (N, 2) pixels of each view.

    Raises:
        InputError: the views do not determine it.

    """
    try:
        start = _fisheye(points, pixels, board, image_size) if model.lens is Equidistant else None
        start = start or _pinhole(points, pixels, board, image_size)
        if model == USUAL:
            return start
        if not model.centre:
            K = start.K.copy()
            K[:2, 2] = _middle(image_size)
            start = replace(start, K=K)
        bundle = adjust(_with_lens(start, model), points, pixels, model.free)
    except np.linalg.LinAlgError as error:
        raise undetermined() from error
    if not (np.all(np.isfinite(bundle.shared)) and bundle.K[0, 0] > 0 and bundle.K[1, 1] > 0):
        raise undetermined()
    return bundle


def undetermined() -> InputError:
    """Return what to say of views that do not determine the camera."""
    return InputError(
        "camera calibration: the views do not determine the camera, wanted the board at different tilts (about 30 to "
        "45 degrees to all four sides) and distances; found views too much alike"
    )


def _with_lens(start: Bundle, model: CameraModel) -> Bundle:
    """The start with a lens of the model: pinholes share their first coefficients."""
    if isinstance(start.lens, model.lens):
        return start
    coefficients = np.zeros(len(model.lens.names))
    coefficients[: len(start.lens.coefficients)] = start.lens.coefficients
    return replace(start, lens=model.lens(coefficients))


def _pinhole(points: Sequence[Array], pixels: Sequence[Array], board: Target, image_size: tuple[int, int]) -> Bundle:
    object_points = [at.astype(np.float32) for at in points]
    image_points = [seen.astype(np.float32) for seen in pixels]
    try:
        _, K, D, turns, moves = cv2.calibrateCamera(
            object_points, image_points, image_size, np.eye(3), np.zeros(5), criteria=_CRITERIA
        )
    except cv2.error as error:
        raise undetermined() from error
    if not (np.all(np.isfinite(K)) and np.all(np.isfinite(D))):
        raise undetermined()
    poses: Array = np.hstack([np.reshape(turns, (-1, 3)), np.reshape(moves, (-1, 3))]).astype(np.float64)
    lens = PlumbBob(np.asarray(D, np.float64).ravel()[:5])
    return Bundle(np.asarray(K, np.float64), lens, poses, board.extent_mm, np.zeros(2))


def _fisheye(points: Sequence[Array], pixels: Sequence[Array], board: Target, image_size: tuple[int, int]) -> Bundle:
    """The best of a few ideal fisheyes, each with its views placed and its focal length adjusted."""
    half_diagonal = 0.5 * float(np.hypot(*image_size))
    fits = []
    for share in _FOCALS:
        f, (cx, cy) = share * half_diagonal, _middle(image_size)
        K = np.array([[f, 0.0, cx], [0.0, f, cy], [0.0, 0.0, 1.0]])
        lens: Lens = Equidistant(np.zeros(4))
        empty = Bundle(K, lens, np.zeros((1, 6)), board.extent_mm, np.zeros(2))
        try:
            poses = [place_view(empty, at, seen).poses[0] for at, seen in zip(points, pixels, strict=True)]
            start = replace(empty, poses=np.array(poses))
            fits.append(adjust(start, points, pixels, ("fx", "fy", "cx", "cy", "k1")))
        except np.linalg.LinAlgError:
            continue
    if not fits:
        raise undetermined()
    return min(fits, key=lambda fit: sum(float(np.sum(r * r)) for r in residuals_of(fit, points, pixels)))


def _middle(image_size: tuple[int, int]) -> tuple[float, float]:
    return (image_size[0] - 1) / 2.0, (image_size[1] - 1) / 2.0
