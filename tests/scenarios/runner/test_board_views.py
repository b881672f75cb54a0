"""The views in which the chessboard is held before the camera."""

import numpy as np
import pytest

from armtwin.models.camera import project
from armtwin.models.camera_files import nominal_camera
from armtwin.scenarios.runner.board_views import board_poses

CORNERS = np.array([[-23.0, -23, 0], [207, -23, 0], [207, 138, 0], [-23, 138, 0]])


@pytest.fixture(scope="module")
def pixels() -> list[np.ndarray]:
    camera = nominal_camera()
    poses = board_poses(camera, CORNERS, 20, np.random.default_rng(4))
    return [project(camera, CORNERS @ T[:3, :3].T + T[:3, 3]) for T in poses]


def test_the_whole_board_is_in_every_view(pixels: list[np.ndarray]) -> None:
    everywhere = np.concatenate(pixels)
    assert everywhere.min() > 0
    assert (everywhere < [1279, 719]).all()


def test_no_view_is_folded_over_by_the_lens(pixels: list[np.ndarray]) -> None:
    for square in pixels:
        sides = np.linalg.norm(np.roll(square, -1, axis=0) - square, axis=1)
        assert sides.min() > 250  # the board's shorter side, 161 mm, at its farthest and most tilted


def test_the_views_reach_all_sides_of_the_picture(pixels: list[np.ndarray]) -> None:
    everywhere = np.concatenate(pixels)
    assert (everywhere.min(axis=0) < [160, 90]).all()
    assert (everywhere.max(axis=0) > [1120, 630]).all()


def test_the_first_view_is_the_board_in_its_mount() -> None:
    assert np.array_equal(board_poses(nominal_camera(), CORNERS, 3, np.random.default_rng(0))[0], np.eye(4))


def test_boards_are_tilted_to_all_four_sides() -> None:
    camera = nominal_camera()
    normals = [camera.R_board_camera @ T[:3, 2] for T in board_poses(camera, CORNERS, 20, np.random.default_rng(4))[1:]]
    tilts = np.array([n[:2] for n in normals])
    assert (tilts.min(axis=0) < -0.25).all()
    assert (tilts.max(axis=0) > 0.25).all()
