"""A board is named by its inner corners."""

import numpy as np
import pytest

from armtwin.calib.camera.board import Board
from armtwin.models.errors import InputError


@pytest.mark.parametrize("text", ["9x6", " 9 x 6 ", "9X6", "9×6"])
def test_a_board_is_written_columns_x_rows(text):
    assert Board.parse(text, 23.0) == Board(columns=9, rows=6, square_mm=23.0)


@pytest.mark.parametrize("text", ["", "9", "9x", "9x6x3", "-9x6", "2x6", "9x61", "99999x6", "9,6"])
def test_other_text_is_refused_with_an_example(text):
    with pytest.raises(InputError, match=r"--board.*9x6 \(a board of 10x7 squares\)"):
        Board.parse(text, 23.0)


@pytest.mark.parametrize("square_mm", [0.023, 0.0, -23.0, float("nan"), 2300.0])
def test_squares_in_metres_are_refused(square_mm):
    with pytest.raises(InputError, match=r"--square-mm.*millimetres"):
        Board.parse("9x6", square_mm)


def test_corners_run_along_x_first(board):
    points = board.points_mm
    np.testing.assert_array_equal(
        points[[0, 1, 8, 9, 53]], np.array([[0, 0, 0], [1, 0, 0], [8, 0, 0], [0, 1, 0], [8, 5, 0]]) * 23
    )
    assert board.n_corners == 54


def test_colour_tells_the_ends_of_a_board_apart_where_half_a_turn_swaps_black_and_white():
    assert Board(9, 6, 23.0).told_by_colour
    assert not Board(9, 7, 23.0).told_by_colour
