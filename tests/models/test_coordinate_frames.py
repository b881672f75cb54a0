import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from armtwin.models.coordinate_frames import R_ROBOT_BOARD, board_to_robot, robot_to_board

numbers = st.floats(-1e3, 1e3)
points = arrays(float, (7, 3), elements=numbers)
base = arrays(float, 3, elements=numbers)


def test_equation_12_turns_half_round_about_y():
    np.testing.assert_array_equal(robot_to_board(np.array([[1.0, 2.0, 3.0]]), np.zeros(3)), [[-1.0, 2.0, -3.0]])
    assert np.linalg.det(R_ROBOT_BOARD) == 1.0


@given(points, base)
def test_there_and_back_is_where_it_was(p, a):
    np.testing.assert_allclose(board_to_robot(robot_to_board(p, a), a), p, atol=1e-9)


@given(points, base)
def test_a_difference_of_points_does_not_know_the_base(p, a):
    """Equation (11): the translation between the frames disappears in F - A."""
    f_a = robot_to_board(p, a) - robot_to_board(p[:1], a)
    np.testing.assert_allclose(f_a @ R_ROBOT_BOARD, p - p[:1], atol=1e-9)


def test_marker_a_is_the_base():
    a = np.array([5.0, 6.0, -80.87])
    np.testing.assert_array_equal(robot_to_board(np.zeros((1, 2)), a), [a])


def test_points_of_the_arms_plane_keep_the_bases_depth():
    board = robot_to_board(np.array([[10.0, 20.0], [-30.0, 5.0]]), np.array([1.0, 2.0, -80.87]))
    np.testing.assert_array_equal(board[:, 2], -80.87)
