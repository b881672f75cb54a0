"""The model that is chosen is the one that the views were seen through, and its uncertainty holds the truth."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from armtwin.calib.camera import Board, Corners, calibrate_camera
from armtwin.calib.camera.comparison import compare_models
from armtwin.calib.camera.models import model_named
from armtwin.models.camera import Camera, project
from armtwin.models.errors import InputError
from armtwin.models.lenses import Equidistant, Lens, PlumbBob, Rational

SIZE = (1280, 720)
ORDINARY = PlumbBob(np.array([-0.2, 0.05, 0.001, -0.0005, 0.0]))
FISHEYE = Equidistant(np.array([0.03, 0.01, -0.01, 0.001]))
WIDE = Rational(np.array([0.28, -0.126, 0.001, -0.0005, -0.01, 0.55, -0.11, -0.036]))


def views_of(
    lens: Lens,
    focal: float,
    board: Board,
    n: int,
    depth: tuple[float, float],
    spread: float,
    bow_mm: float = 0.0,
    tilt: float = 0.6,
    seed: int = 1,
) -> list[Corners]:
    """Views all over the picture, with 0.1 px of noise; the board may bow along x."""
    K = np.array([[focal, 0.0, 642.0], [0.0, focal, 355.0], [0.0, 0.0, 1.0]])
    camera = Camera(*SIZE, K, lens, np.eye(3), np.zeros(3))
    rng, found, points = np.random.default_rng(seed), [], board.points_mm.copy()
    middle = points.mean(axis=0)
    points[:, 2] += bow_mm * (1.0 - (2.0 * points[:, 0] / board.extent_mm[1, 0] - 1.0) ** 2)
    while len(found) < n:
        turn = cv2.Rodrigues(np.append(rng.uniform(-tilt, tilt, 2), rng.uniform(-0.3, 0.3)))[0]
        R = turn @ np.diag([-1.0, -1.0, 1.0])
        t = rng.uniform(*depth) * np.append(rng.uniform(-1.0, 1.0, 2) * spread, 1.0) - R @ middle
        pixels = project(replace(camera, R_board_camera=R, t_board_camera_mm=t), points)
        before = (points @ R.T + t)[:, 2].min() > 30.0
        if before and np.all(pixels > 5.0) and np.all(pixels < np.array(SIZE) - 5.0):
            found.append(Corners(f"view {len(found)}", pixels + rng.normal(0.0, 0.1, pixels.shape)))
    return found


@pytest.mark.parametrize(
    ("lens", "focal", "depth", "spread", "bow_mm", "chosen"),
    [
        (ORDINARY, 900.0, (250.0, 450.0), 0.5, 0.0, "plumb_bob"),
        (ORDINARY, 900.0, (250.0, 450.0), 0.5, 0.8, "plumb_bob_bowed_board"),
        (FISHEYE, 450.0, (120.0, 300.0), 1.5, 0.0, "equidistant"),
        (WIDE, 640.0, (120.0, 300.0), 1.4, 0.0, "rational"),
    ],
)
def test_the_lens_is_told_by_views_left_out(board, lens, focal, depth, spread, bow_mm, chosen):
    views = views_of(lens, focal, board, 12, depth, spread, bow_mm)
    comparison = compare_models(views, board, SIZE)
    assert comparison is not None
    assert comparison.chosen.name == chosen
    fit = calibrate_camera(views, board, SIZE, model=comparison.chosen)
    assert abs(fit.camera.K[0, 0] - focal) < 3.0 * fit.total_std["fx"]
    assert fit.total_std["fx"] < 0.005 * focal
    np.testing.assert_allclose(fit.bow_mm, [bow_mm, 0.0], atol=0.1)


def test_a_wide_lens_fitted_as_an_ordinary_one_is_not_called_certain(board):
    errors, told, naive = [], [], []
    for seed in range(4):
        views = views_of(FISHEYE, 450.0, board, 14, (120.0, 300.0), 1.5, seed=seed)
        fit = calibrate_camera(views, board, SIZE, model=model_named("plumb_bob"))
        errors.append(abs(fit.camera.K[0, 0] - 450.0))
        told.append(fit.total_std["fx"])
        naive.append(fit.std["fx"])
    assert np.mean(told) > 3.0 * np.mean(naive)
    assert np.sqrt(np.mean(np.square(errors))) < 2.0 * np.mean(told)


def test_a_board_held_still_is_refused_with_how_to_move_it(board):
    views = views_of(ORDINARY, 900.0, board, 12, (300.0, 320.0), 0.1, tilt=0.03)
    with pytest.raises(InputError, match=r"tilted alike in all 12 views .* turn the board between photographs"):
        calibrate_camera(views, board, SIZE)
    with pytest.raises(InputError, match="tilted alike"):
        compare_models(views, board, SIZE)


def test_few_views_are_not_compared(board):
    views = views_of(ORDINARY, 900.0, board, 4, (250.0, 450.0), 0.5)
    assert compare_models(views, board, SIZE) is None
