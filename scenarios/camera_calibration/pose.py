"""A camera whose intrinsics are known: its pose alone, from one photograph of the board."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from armtwin.calib.camera.bundle import Bundle, place_view, residuals_of
from armtwin.calib.camera.fit import rms_px, rotations_of, upright
from armtwin.calib.camera.uncertainty import uncertainty
from armtwin.models.camera import Camera
from armtwin.models.errors import InputError
from armtwin.scenarios.camera_calibration.job import Views

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class PlacedCamera:
    """The camera in its place.

    Attributes:
        camera: the intrinsics that were given, the pose that was found.
        name: of the photograph.
        rms_px: root mean square distance of measured and predicted points.
        pose_std: (6,) of rotation (rad, about the camera's axes) and translation (mm).

    """

    camera: Camera
    name: str
    rms_px: float
    pose_std: Array


def place_camera(camera: Camera, seen: Views, reference: str | None = None) -> PlacedCamera:
    """Keep a camera's intrinsics, and take its pose from the view of the reference picture, or the first.

    Raises:
        InputError: no board was seen, the pictures have another size, or the view determines no pose.

    """
    if not seen.views:
        raise InputError(
            f"camera calibration: found {seen.target} in none of {len(seen.unseen)} images; show the whole board with "
            "its white margin, sharp and evenly lit, and check --board and --target"
        )
    known = (camera.image_width, camera.image_height)
    if seen.size != known:
        raise InputError(
            f"{seen.views[0].name}: found {seen.size[0]}x{seen.size[1]} px, wanted {known[0]}x{known[1]} px as in "
            "--intrinsics; photograph at the size that the camera was calibrated with"
        )
    at = seen.index(reference)
    board, views = upright(seen.views, seen.target, at)
    view = views[at]
    points = board.points_of(view)
    empty = Bundle(camera.K, camera.lens, np.zeros((1, 6)), board.extent_mm, np.zeros(2))
    try:
        placed = place_view(empty, points, view.pixels)
        spread = uncertainty(placed, [points], [view.pixels], (), known)
    except np.linalg.LinAlgError:
        raise InputError(
            f"{view.name}: the board determines no pose with these intrinsics; check that --intrinsics is this camera's"
        ) from None
    pose = placed.poses[0]
    return PlacedCamera(
        camera=replace(camera, R_board_camera=rotations_of(pose[None])[0], t_board_camera_mm=pose[3:]),
        name=view.name,
        rms_px=rms_px(residuals_of(placed, [points], [view.pixels])),
        pose_std=spread.pose_std[0],
    )
