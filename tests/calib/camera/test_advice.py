"""Advice names the views that are out of line and the tilts that are missing."""

import cv2
import numpy as np
import pytest

from armtwin.calib.camera.advice import advise, missing_tilts, poor_views, tilts
from armtwin.calib.camera.coverage import cover


def rotation(x_deg: float = 0.0, y_deg: float = 0.0) -> np.ndarray:
    """Turn the upright board about the camera's x (right) and y (down) axes."""
    R, _ = cv2.Rodrigues(np.deg2rad([x_deg, y_deg, 0.0]))
    return R @ np.diag([-1.0, -1.0, 1.0])


def test_a_view_far_above_the_others_is_poor():
    errors = np.array([0.20, 0.19, 0.21, 0.22, 0.90, 0.18, 0.20])
    np.testing.assert_array_equal(np.flatnonzero(poor_views(errors)), [4])


def test_views_all_alike_are_kept_though_one_must_be_the_worst():
    assert not poor_views(np.array([0.200, 0.200, 0.201, 0.200, 0.199, 0.210])).any()


def test_ordinary_scatter_is_kept():
    rng = np.random.default_rng(0)
    # The rms over 54 corners of normal noise scatters by 7 %.
    worlds = 0.2 * (1 + 0.07 * rng.standard_normal((500, 20)))
    assert np.mean([poor_views(errors).any() for errors in worlds]) < 0.02


def test_three_views_are_always_left():
    assert (~poor_views(np.array([0.0, 0.0, 5.0, 9.0]))).sum() >= 3


@pytest.mark.parametrize(
    ("board", "side"),
    [
        (rotation(y_deg=30.0), "right"),
        (rotation(y_deg=-30.0), "left"),
        (rotation(x_deg=30.0), "top"),
        (rotation(x_deg=-30.0), "bottom"),
    ],
)
def test_a_tilt_is_named_by_the_side_of_the_picture_that_it_brings_nearer(board, side):
    assert side not in missing_tilts(board[None])
    assert len(missing_tilts(board[None])) == 3
    # The side in question has the smaller depth.
    direction = {"left": [-1, 0], "right": [1, 0], "top": [0, -1], "bottom": [0, 1]}[side]
    corners = np.array([[x, y, 0.0] for x in (-1, 1) for y in (-1, 1)]) @ board.T
    towards = corners[:, :2] @ np.array(direction)
    assert corners[towards > 0, 2].mean() < corners[towards < 0, 2].mean()


def test_the_size_of_a_tilt_is_its_angle():
    np.testing.assert_allclose(
        np.linalg.norm(tilts(np.array([rotation(20.0), rotation()])), axis=1), [np.deg2rad(20.0), 0.0], atol=1e-9
    )


def test_few_flat_views_in_the_middle_want_more_of_everything():
    middle = cover(np.array([[300.0, 220.0], [340.0, 220.0], [320.0, 260.0]]), (640, 480))
    advice = advise(["a", "b", "c"], np.array([0.2, 0.2, 0.2]), np.array([rotation()] * 3), middle)
    assert advice.drop == ()
    text = "; ".join(advice.add)
    for part in ("more views: 3", "top left", "corners: those here reach", "left, right, top, bottom side tilted"):
        assert part in text
