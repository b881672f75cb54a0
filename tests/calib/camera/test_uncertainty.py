"""Standard deviations mean what they say: intervals cover the truth, and views that err together are seen."""

import cv2
import numpy as np

from armtwin.calib.camera import Corners, calibrate_camera

SIZE = (1280, 720)


def truth_of(camera) -> np.ndarray:
    return np.array([*camera.K[[0, 1, 0, 1], [0, 1, 2, 2]], *camera.lens.coefficients])


def test_standard_deviations_agree_with_opencv(simulate, board):
    views = simulate(10, noise_px=0.1)
    fit = calibrate_camera(views, board, SIZE)
    points = [board.points_mm.astype(np.float32)] * len(views)
    pixels = [view.pixels.astype(np.float32) for view in views]
    *_, std, pose_std, _ = cv2.calibrateCameraExtended(
        points, pixels, SIZE, None, None, criteria=(cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS, 200, 1e-12)
    )
    np.testing.assert_allclose(list(fit.std.values()), std.ravel()[:9], rtol=1e-3)
    np.testing.assert_allclose(fit.uncertainty.pose_std[:, 3:], pose_std.reshape(-1, 6)[:, 3:], rtol=1e-3)


def test_intervals_cover_the_truth_as_often_as_they_say(simulate, board, webcam):
    n_worlds, exact = 80, simulate(8)
    intrinsics, poses = [], []
    for seed in range(n_worlds):
        rng = np.random.default_rng(seed)
        views = [Corners(v.name, v.pixels + rng.normal(0.0, 0.2, v.pixels.shape)) for v in exact]
        fit = calibrate_camera(views, board, SIZE)
        intrinsics.append((truth_of(fit.camera) - truth_of(webcam)) / fit.uncertainty.std)
        turn, _ = cv2.Rodrigues(fit.camera.R_board_camera @ webcam.R_board_camera.T)
        move = fit.camera.t_board_camera_mm - webcam.t_board_camera_mm
        poses.append(np.append(turn.ravel(), move) / fit.uncertainty.pose_std[0])
    for z in (np.array(intrinsics), np.array(poses)):
        # 80 worlds: an rms of z is known to 1/sqrt(160) = 8 %, a share of 95 % to 2.4 %; three of those each.
        np.testing.assert_allclose(np.sqrt(np.mean(z**2, axis=0)), 1.0, atol=0.24)
        assert 0.92 < np.mean(np.abs(z) < 1.96) < 0.98


def test_first_order_influence_is_that_of_a_fit_without_the_view(simulate, board):
    views = simulate(12, noise_px=0.2)
    fit = calibrate_camera(views, board, SIZE)
    for i in (0, 5, 11):
        without = calibrate_camera(views[:i] + views[i + 1 :], board, SIZE)
        change = truth_of(without.camera) - truth_of(fit.camera)
        np.testing.assert_allclose(
            fit.uncertainty.without_view[i] / fit.uncertainty.std, change / fit.uncertainty.std, atol=0.1
        )


def test_where_whole_views_err_the_jackknife_covers_and_the_covariance_does_not(simulate, board, webcam):
    exact = simulate(14, seed=2)
    by_covariance, by_jackknife = [], []
    for seed in range(40):
        rng = np.random.default_rng(seed)
        views = []
        for view in exact:
            # A view seen through moving air, or a board that bends: its corners err together.
            stretch = np.eye(2) + rng.normal(0.0, 0.002, (2, 2))
            middle = view.pixels.mean(axis=0)
            noise = rng.normal(0.0, 0.05, view.pixels.shape)
            views.append(Corners(view.name, middle + (view.pixels - middle) @ stretch + noise))
        fit = calibrate_camera(views, board, SIZE)
        error = (truth_of(fit.camera) - truth_of(webcam))[:4]
        by_covariance.append(error / fit.uncertainty.std[:4])
        by_jackknife.append(error / fit.uncertainty.jackknife_std[:4])
    assert np.sqrt(np.mean(np.square(by_covariance))) > 1.5
    assert 0.6 < np.sqrt(np.mean(np.square(by_jackknife))) < 1.3


def test_few_views_have_no_jackknife(simulate, board):
    fit = calibrate_camera(simulate(4, noise_px=0.1), board, SIZE)
    assert all(np.isnan(value) for value in fit.jackknife_std.values())
    assert set(fit.std) == {"fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3"}
