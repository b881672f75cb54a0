"""What every camera file says in its own words: size, camera matrix, lens, perhaps the pose of the board."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armtwin.models.camera import Camera
from armtwin.models.errors import InputError
from armtwin.models.lenses import lens_named

Array = NDArray[np.float64]

# No sensor is larger; a bound keeps a typing error from making a picture that fills the memory.
MAX_IMAGE_PX = 65536
# How far R Rᵀ may be from identity, per element: written numbers are exact, so this allows for seven printed digits.
ROTATION_TOLERANCE = 1e-6


@dataclass(frozen=True, eq=False)
class Calibration:
    """The numbers of a file, before it is known whether a camera can have them.

    Attributes:
        width, height: of the image, as found.
        K: (3, 3) camera matrix, OpenCV's pixel origin.
        model: the lens model's name, ROS's.
        coefficients: in OpenCV's order.
        R, t: pose of the board, `X_camera = R X_board + t`, mm; None where the file has none.
        size_keys, matrix_key: what the file calls them, for messages.

    """

    width: object
    height: object
    K: Array
    model: str
    coefficients: Sequence[float]
    R: Array | None = None
    t: Array | None = None
    size_keys: tuple[str, str] = ("image_width", "image_height")
    matrix_key: str = "camera_matrix"

    def camera(self) -> Camera:
        """Return the camera; the board stands at it where no pose is known.

        Raises:
            InputError: no camera can have these numbers, or it was never calibrated; starts with the key.

        """
        width, height = (_size(k, v) for k, v in zip(self.size_keys, (self.width, self.height), strict=True))
        self._check_matrix()
        lens = lens_named(self.model, self.coefficients)
        R, t = np.eye(3) if self.R is None else self.R, np.zeros(3) if self.t is None else self.t
        _check_rotation(R)
        return Camera(width, height, self.K, lens, R, t)

    def _check_matrix(self) -> None:
        K = self.K
        if not np.any(K[:2, :2]):
            raise InputError(
                f"{self.matrix_key}: found zeros, wanted focal lengths in pixels: this camera was never calibrated; "
                "photograph a chessboard and run `armtwin calibrate-camera`"
            )
        if not (K[0, 0] > 0 and K[1, 1] > 0 and K[1, 0] == 0 and np.array_equal(K[2], [0, 0, 1])):
            raise InputError(
                f"{self.matrix_key}: found {K.tolist()}, wanted [[f_x, s, c_x], [0, f_y, c_y], [0, 0, 1]] "
                "with focal lengths above 0 px, row by row"
            )


def pinhole(fx: float, fy: float, cx: float, cy: float, skew: float = 0.0) -> Array:
    """(3, 3) camera matrix, px."""
    return np.array([[fx, skew, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]])


def _size(key: str, value: object) -> int:
    if isinstance(value, float) and value.is_integer():
        value = int(value)
    if isinstance(value, bool) or not isinstance(value, int) or not 1 <= value <= MAX_IMAGE_PX:
        add = "; add image_width and image_height to the file" if value is None else ""
        raise InputError(
            f"{key}: found {'nothing' if value is None else repr(value)[:40]}, wanted whole pixels from 1 to "
            f"{MAX_IMAGE_PX}: the size of the pictures that the camera was calibrated with{add}"
        )
    return value


def _check_rotation(R: Array) -> None:
    error = float(np.abs(R @ R.T - np.eye(3)).max())
    if not (error < ROTATION_TOLERANCE and np.linalg.det(R) > 0):
        raise InputError(
            f"board_to_camera_rotation: found a matrix {error:.1g} away from a rotation "
            f"(determinant {np.linalg.det(R):.3g}), wanted an orthonormal one to {ROTATION_TOLERANCE:g}; "
            "give more digits or re-orthonormalise it"
        )
