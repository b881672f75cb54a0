"""Bundle adjustment gives back the camera, the poses and the board's bow, by slopes that are its own."""

import cv2
import numpy as np
import pytest

from armtwin.calib.camera.bundle import Bundle, adjust, free_names, place_view, predict, residuals_of, slopes
from armtwin.models.lenses import Equidistant, PlumbBob, ThinPrism

PRISM = [0.28, -0.126, 0.001, -0.0005, -0.01, 0.55, -0.11, -0.036, 0.002, -0.001, -0.003, 0.0005]
LENSES = [
    PlumbBob(np.array([0.1630, 0.0428, 0.0064, 0.0016, -2.1819])),
    Equidistant(np.array([0.03, 0.01, -0.01, 0.001])),
    ThinPrism(np.array(PRISM)),
]
each_lens = pytest.mark.parametrize("lens", LENSES, ids=lambda lens: lens.model)


def bundle_of(lens, board, n=8) -> Bundle:
    rng = np.random.default_rng(0)
    poses = [[*rng.uniform(-0.4, 0.4, 3), *rng.uniform(-60, 0, 2), rng.uniform(280, 380)] for _ in range(n)]
    K = np.array([[600.0, 0.0, 320.0], [0.0, 605.0, 240.0], [0.0, 0.0, 1.0]])
    return Bundle(K, lens, np.array(poses), board.extent_mm, np.array([0.6, -0.3]))


@each_lens
def test_slopes_are_those_of_central_differences(lens, board):
    bundle, points, h = bundle_of(lens, board), board.points_mm, 1e-6
    by_pose, by_shared = slopes(bundle, points, 2)
    still, fixed = np.zeros((8, 6)), np.zeros(len(bundle.names))

    def difference(shared, poses):
        there, back = bundle.moved(shared, poses), bundle.moved(-shared, -poses)
        return (predict(there, points, 2) - predict(back, points, 2)).ravel() / (2 * h)

    for k in range(6):
        step = still.copy()
        step[2, k] = h
        np.testing.assert_allclose(by_pose[:, k], difference(fixed, step), atol=1e-4)
    for k, step in enumerate(h * np.eye(len(bundle.names))):
        np.testing.assert_allclose(by_shared[:, k], difference(step, still), atol=1e-4)


@each_lens
def test_exact_pixels_give_camera_and_bow_back(lens, board):
    truth = bundle_of(lens, board)
    points = [board.points_mm] * 8
    pixels = [predict(truth, board.points_mm, view) for view in range(8)]
    off = np.zeros(len(truth.names))
    off[:4] = [30.0, -20.0, 8.0, -6.0]
    start = truth.moved(off, np.random.default_rng(1).normal(0.0, 0.02, (8, 6)))
    start = Bundle(start.K, start.lens, start.poses, truth.extent_mm, np.zeros(2))
    fit = adjust(start, points, pixels, free_names(lens, bow=True))
    np.testing.assert_allclose(np.concatenate(residuals_of(fit, points, pixels)), 0.0, atol=1e-5)
    np.testing.assert_allclose(fit.bow_mm, truth.bow_mm, atol=1e-3)


@each_lens
def test_a_view_is_placed_by_a_camera_that_is_known(lens, board):
    truth = bundle_of(lens, board, 3)
    placed = place_view(truth, board.points_mm, predict(truth, board.points_mm, 1))
    turn, _ = cv2.Rodrigues(cv2.Rodrigues(placed.poses[0, :3])[0] @ cv2.Rodrigues(truth.poses[1, :3])[0].T)
    np.testing.assert_allclose(turn, 0.0, atol=1e-6)
    np.testing.assert_allclose(placed.poses[0, 3:], truth.poses[1, 3:], atol=1e-3)
