"""Corners are found to a few hundredths of a pixel, each time in the same order, and never on another board."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from armtwin.calib.camera.board import Board
from armtwin.calib.camera.corners import USUAL_WINDOW_PX, find_corners, window_limit_px
from armtwin.calib.camera.fit import MIN_VIEWS
from armtwin.models.camera import project


def rms(a: np.ndarray, b: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.sum((a - b) ** 2, axis=1))))


@pytest.fixture(scope="module")
def picture(photograph, small_camera, board):
    return photograph(small_camera, board, noise=2.0)


def test_corners_lie_where_the_camera_projects_them(picture, small_camera, board):
    found = find_corners(picture, board)
    assert rms(found, project(small_camera, board.points_mm)) < 0.05


def test_a_colour_picture_gives_the_same_corners(picture, board):
    colour = cv2.cvtColor(picture, cv2.COLOR_GRAY2BGR)
    np.testing.assert_allclose(find_corners(colour, board), find_corners(picture, board), atol=0.01)


@pytest.mark.parametrize("turns", [1, 2, 3])
def test_the_order_follows_the_board_when_the_picture_is_turned(picture, board, turns):
    found = find_corners(picture, board)
    turned = find_corners(np.ascontiguousarray(np.rot90(picture, turns)), board)
    h, w = picture.shape
    back = {
        1: lambda p: np.stack([w - 1 - p[:, 1], p[:, 0]], axis=1),
        2: lambda p: np.array([w - 1, h - 1]) - p,
        3: lambda p: np.stack([p[:, 1], h - 1 - p[:, 0]], axis=1),
    }[turns]
    np.testing.assert_allclose(back(turned), found, atol=0.1)


def test_the_first_corner_lies_beside_a_black_corner_square(photograph, small_camera, board):
    # Squares of this board's rendering are dark where column + row is even, the corner square (-1, -1) among them.
    half_turn = np.diag([-1.0, -1.0, 1.0])
    R = small_camera.R_board_camera @ half_turn
    middle = np.array([92.0, 57.5, 0.0])
    camera = replace(
        small_camera,
        R_board_camera=R,
        t_board_camera_mm=small_camera.t_board_camera_mm + (small_camera.R_board_camera - R) @ middle,
    )
    found = find_corners(photograph(camera, board), board)
    assert rms(found, project(camera, board.points_mm)) < 0.05


def test_a_board_that_looks_the_same_after_half_a_turn_starts_so_that_y_points_up(photograph, small_camera):
    board = Board(columns=8, rows=6, square_mm=23.0)
    found = find_corners(photograph(small_camera, board), board)
    assert rms(found, project(small_camera, board.points_mm)) < 0.05


def test_a_square_board_has_y_up(photograph, small_camera):
    board = Board(columns=6, rows=6, square_mm=23.0)
    found = find_corners(photograph(small_camera, board), board)
    assert rms(found, project(small_camera, board.points_mm)) < 0.05


@pytest.mark.parametrize("text", ["8x6", "8x5", "7x4", "9x7", "10x7"])
def test_another_board_is_not_taken_for_the_one_asked_for(picture, text):
    assert find_corners(picture, Board.parse(text, 23.0)) is None


@pytest.mark.parametrize("text", ["8x6", "5x4"])
def test_photographs_of_a_larger_board_with_narrow_outer_squares_are_no_calibration(chessboard_folder, text):
    board = Board.parse(text, 25.0)
    images = [cv2.imread(str(path), cv2.IMREAD_GRAYSCALE) for path in sorted(chessboard_folder.glob("*.jpg"))]
    assert sum(find_corners(image, board) is not None for image in images) < MIN_VIEWS


@pytest.mark.parametrize("text", ["9x6", "6x9"])
@pytest.mark.parametrize("mirrored", [False, True])
def test_x_and_y_run_clockwise_so_that_z_points_away(picture, text, mirrored):
    board = Board.parse(text, 23.0)
    seen = np.ascontiguousarray(picture[:, ::-1]) if mirrored else picture
    grid = find_corners(seen, board).reshape(board.rows, board.columns, 2)
    x, y = grid[0, 1] - grid[0, 0], grid[1, 0] - grid[0, 0]
    assert x[0] * y[1] - x[1] * y[0] > 0


def test_a_picture_without_a_board_gives_none(board):
    rng = np.random.default_rng(0)
    assert find_corners(rng.integers(0, 255, (240, 320), dtype=np.uint8), board) is None


def test_a_board_cut_off_by_the_picture_gives_none(picture, board):
    corner = np.rint(find_corners(picture, board)[27]).astype(int)
    assert find_corners(np.ascontiguousarray(picture[: corner[1]]), board) is None


def test_the_adapted_window_stays_clear_of_neighbours(photograph, small_camera, board):
    far = replace(small_camera, t_board_camera_mm=small_camera.t_board_camera_mm * 1.9)
    picture, truth = photograph(far, board), project(far, board.points_mm)
    assert window_limit_px(truth.reshape(6, 9, 2)) < USUAL_WINDOW_PX
    adapted = rms(find_corners(picture, board), truth)
    assert adapted < 0.06
    assert rms(find_corners(picture, board, USUAL_WINDOW_PX), truth) > 2 * adapted
