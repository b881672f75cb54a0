"""A joint axis that is not square to the plane."""

from dataclasses import replace

import numpy as np
import pytest

from armtwin.models.catalogue.predict import marker_points
from tests.support.contexts import active, context_of, drawn

COLUMNS = {1: "a", 2: "b", 3: "c"}


def tilted(joint: int, square_at_zero: float, q: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray]:
    context = context_of(q)
    lean = active("axis_tilt", [0.03, -0.05, square_at_zero], joint=joint)
    geometry = drawn(context)
    return marker_points(context, geometry, context.q_cmd, (lean,)), marker_points(context, geometry, context.q_cmd)


@pytest.mark.parametrize("square", [0.0, 1.0])
@pytest.mark.parametrize("joint", [1, 2, 3])
def test_what_lies_beyond_the_joint_moves_rigidly_about_it_and_nothing_else_moves(joint: int, square: float) -> None:
    leaning, flat = tilted(joint, square)
    np.testing.assert_array_equal(leaning[:, :joint], flat[:, :joint])
    pivot = flat[:, joint - 1 : joint]
    np.testing.assert_allclose(
        np.linalg.norm(leaning - pivot, axis=-1)[:, joint:], np.linalg.norm(flat - pivot, axis=-1)[:, joint:]
    )
    assert np.abs(leaning[:, joint:, 2]).max() > 0.1


def test_a_link_that_is_square_to_the_plane_at_zero_angle_lies_in_it_there() -> None:
    leaning, flat = tilted(2, 1.0, np.zeros((3, 3)))
    np.testing.assert_allclose(leaning, flat, atol=1e-9)


def test_a_link_that_is_square_to_its_axis_circles_in_a_tilted_plane() -> None:
    q = np.zeros((30, 3))
    q[:, 1] = np.linspace(-1.0, 1.0, 30)
    leaning, flat = tilted(2, 0.0, q)
    arm = leaning[:, 2] - flat[:, 1]
    assert np.linalg.svd(arm, compute_uv=False)[2] < 1e-9


def test_the_zeros_of_the_joints_change_nothing_of_where_a_link_is_square_to_the_plane() -> None:
    context = context_of(np.zeros((3, 3)))
    lean = active("axis_tilt", [0.03, -0.05, 1.0], joint=3)
    turned = replace(drawn(context), links=drawn(context).links * np.exp(1j * np.cumsum([0.1, 0.08, -0.05])))
    leaning = marker_points(context, turned, context.q_cmd, (lean,))
    np.testing.assert_allclose(leaning, marker_points(context, turned, context.q_cmd), atol=1e-9)
