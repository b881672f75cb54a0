"""The camera is bumped at one sample."""

import numpy as np
from scipy.spatial.transform import Rotation

from armtwin.models.camera import Camera, project
from armtwin.models.catalogue.predict import marker_points
from armtwin.models.coordinate_frames import robot_to_board
from tests.support.contexts import BASE_MM, active, context_of, drawn, pixels

BUMP = [0.01, -0.004, 0.006, 1.5, -2.0, 3.0]


def test_before_the_bump_nothing_changes() -> None:
    context = context_of()
    moved = pixels(context, active("camera_moved", [*BUMP, 12.0])) - pixels(context)
    assert not moved[:12].any()
    assert np.abs(moved[12:]).min() > 0.0


def test_afterwards_the_scene_is_turned_and_shifted_in_the_camera_s_axes() -> None:
    context = context_of()
    camera = context.camera
    assert camera is not None
    turn = Rotation.from_rotvec(BUMP[:3]).as_matrix()
    bumped = Camera(
        camera.image_width,
        camera.image_height,
        camera.K,
        camera.lens,
        turn @ camera.R_board_camera,
        turn @ camera.t_board_camera_mm + BUMP[3:],
    )
    board = robot_to_board(marker_points(context, drawn(context), context.q_cmd), BASE_MM)
    seen = project(bumped, board.reshape(-1, 3)).reshape(-1, 4, 2)
    np.testing.assert_allclose(pixels(context, active("camera_moved", [*BUMP, 1.0]))[1:], seen[1:], atol=1e-6)


def test_it_moves_marker_a_which_no_joint_does() -> None:
    context = context_of()
    moved = pixels(context, active("camera_moved", [*BUMP, 12.0])) - pixels(context)
    assert np.linalg.norm(moved[12:, 0], axis=-1).min() > 1.0
    slipped = pixels(context, active("joint_slip", [0.1, 12.0], joint=1)) - pixels(context)
    assert not slipped[:, 0].any()
