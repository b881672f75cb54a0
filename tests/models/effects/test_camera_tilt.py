"""The camera's orientation is off for all of a recording."""

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from armtwin.models.camera import project
from armtwin.models.catalogue.predict import marker_points
from armtwin.models.coordinate_frames import robot_to_board
from tests.support.contexts import BASE_MM, active, context_of, drawn, pixels


def test_the_picture_is_that_of_the_camera_turned_about_its_centre() -> None:
    context = context_of()
    assert context.camera is not None
    tilt = Rotation.from_rotvec([0.02, -0.03, 0.0]).as_matrix()
    turned = replace(
        context.camera,
        R_board_camera=tilt @ context.camera.R_board_camera,
        t_board_camera_mm=tilt @ context.camera.t_board_camera_mm,
    )
    board = robot_to_board(marker_points(context, drawn(context), context.q_cmd), BASE_MM)
    seen = project(turned, board.reshape(-1, 3)).reshape(-1, 4, 2)
    np.testing.assert_allclose(pixels(context, active("camera_tilt", [0.02, -0.03])), seen, atol=1e-6)


def test_it_bends_the_picture_as_no_shift_of_the_base_does() -> None:
    context = context_of()
    moved = pixels(context, active("camera_tilt", [0.03, 0.0])) - pixels(context)
    assert np.ptp(moved, axis=(0, 1)).max() > 2.0
