"""The fit recovers the camera that took the views, in Table 2's frame, or says why it cannot."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from armtwin.calib.camera import Board, Corners, calibrate_camera, find_corners
from armtwin.calib.camera.fit import rotations_of
from armtwin.models.camera import project
from armtwin.models.camera_files import read_camera
from armtwin.models.errors import InputError

SIZE = (1280, 720)


def truth_of(camera) -> np.ndarray:
    return np.array([*camera.K[[0, 1, 0, 1], [0, 1, 2, 2]], *camera.lens.coefficients])


class TestRecovery:
    def test_exact_corners_give_the_camera_back(self, simulate, board, webcam):
        fit = calibrate_camera(simulate(12), board, SIZE)
        # OpenCV holds corners in single precision: 3e-5 px at 640 px.
        np.testing.assert_allclose(fit.camera.K, webcam.K, atol=2e-3)
        np.testing.assert_allclose(fit.camera.lens.coefficients, webcam.lens.coefficients, atol=2e-4)
        np.testing.assert_allclose(fit.camera.T_board_camera, webcam.T_board_camera, atol=1e-3)
        assert fit.rms_px < 1e-4

    def test_three_views_suffice(self, simulate, board, webcam):
        fit = calibrate_camera(simulate(3, seed=4), board, SIZE)
        np.testing.assert_allclose(fit.camera.K, webcam.K, atol=0.05)

    def test_rms_and_sigma_are_those_of_the_noise(self, simulate, board):
        fit = calibrate_camera(simulate(20, noise_px=0.1), board, SIZE)
        assert fit.uncertainty.sigma_px == pytest.approx(0.1, rel=0.05)
        assert fit.rms_px == pytest.approx(0.1 * np.sqrt(2), rel=0.07)
        assert [r.shape for r in fit.residuals_px] == [(54, 2)] * 20
        np.testing.assert_allclose(fit.per_view_rms_px, 0.1 * np.sqrt(2), rtol=0.3)

    def test_residuals_are_measured_less_projected(self, simulate, board):
        fit = calibrate_camera(simulate(5, noise_px=0.1), board, SIZE)
        expected = fit.views[0].pixels - project(fit.camera, board.points_mm)
        np.testing.assert_allclose(fit.residuals_px[0], expected, atol=1e-6)


class TestFrame:
    def test_the_board_upright_has_x_left_y_up_z_away(self, simulate, board):
        fit = calibrate_camera(simulate(6), board, SIZE)
        np.testing.assert_allclose(fit.camera.R_board_camera, np.diag([-1.0, -1.0, 1.0]), atol=0.06)

    def test_views_counted_from_the_other_end_give_the_same_frame(self, simulate, board):
        views = simulate(6)
        turned = [Corners(view.name, view.pixels[::-1]) for view in views]
        a, b = calibrate_camera(views, board, SIZE).camera, calibrate_camera(turned, board, SIZE).camera
        np.testing.assert_allclose(b.T_board_camera, a.T_board_camera, atol=1e-3)

    def test_the_pose_is_that_of_the_reference_view(self, simulate, board):
        views = simulate(6)
        fit = calibrate_camera(views, board, SIZE, reference=3)
        assert fit.reference == 3
        np.testing.assert_allclose(project(fit.camera, board.points_mm), views[3].pixels, atol=0.01)


class TestBadViews:
    def test_two_views_are_too_few(self, simulate, board):
        with pytest.raises(InputError, match="found 2 usable views, wanted at least 3"):
            calibrate_camera(simulate(12)[:2], board, SIZE)

    def test_a_view_of_another_board_is_named(self, simulate, board):
        views = simulate(4)
        views[2] = Corners("odd.png", views[2].pixels[:48])
        with pytest.raises(InputError, match=r"odd\.png: found 48 corners, wanted 54"):
            calibrate_camera(views, board, SIZE)

    @pytest.mark.parametrize("pixel", [[np.nan, 10.0], [1300.0, 10.0], [10.0, -5.0]])
    def test_a_corner_outside_the_picture_is_refused(self, simulate, board, pixel):
        views = simulate(4)
        views[1].pixels[7] = pixel
        with pytest.raises(InputError, match="view 1: found a corner that is missing or outside"):
            calibrate_camera(views, board, SIZE)

    def test_one_view_taken_again_and_again_does_not_determine_the_camera(self, simulate, board, webcam):
        flat = replace(webcam, R_board_camera=np.diag([-1.0, -1.0, 1.0]))
        pixels = project(flat, board.points_mm)
        rng = np.random.default_rng(0)
        views = [Corners(f"view {i}", pixels + rng.normal(0.0, 0.05, pixels.shape)) for i in range(5)]
        with pytest.raises(InputError, match=r"tilted alike in all 5 views|do not determine the camera"):
            calibrate_camera(views, board, SIZE)

    def test_an_unknown_reference_is_refused(self, simulate, board):
        with pytest.raises(InputError, match="reference view: found 9"):
            calibrate_camera(simulate(4), board, SIZE, reference=9)


@pytest.fixture(scope="module")
def fits(chessboard_folder):
    """Fits to the photographs, by half window of the refinement."""
    board = Board.parse("9x6", 25.0)

    def views(window_px):
        images = sorted(chessboard_folder.glob("*.jpg"))
        return [Corners(path.name, find_corners(cv2.imread(str(path)), board, window_px)) for path in images]

    return {window: calibrate_camera(views(window), board, (640, 480)) for window in (11, None)}


@pytest.fixture
def published(chessboard_folder) -> np.ndarray:
    return truth_of(read_camera(chessboard_folder / "published_intrinsics.yml"))


class TestPhotographs:
    def test_the_usual_window_matches_the_published_camera(self, fits, published):
        assert np.all(np.abs(truth_of(fits[11].camera) - published) < 0.5 * fits[11].uncertainty.std)

    def test_the_adapted_window_agrees_with_it_within_both_uncertainties(self, fits, published):
        # The published fit has the usual window's poor views, so its uncertainty is that of the first fit.
        spread = np.hypot(fits[11].uncertainty.jackknife_std, fits[None].uncertainty.jackknife_std)
        assert np.all(np.abs(truth_of(fits[None].camera) - published) < 2.0 * spread)

    def test_the_usual_window_gives_the_published_figures_and_shows_the_poor_views(self, fits):
        fit = fits[11]
        assert fit.rms_px == pytest.approx(0.409, abs=0.001)
        np.testing.assert_allclose(truth_of(fit.camera)[:4], [536.07, 536.02, 342.37, 235.54], atol=0.05)
        assert fit.advice.drop == ("left02.jpg", "left13.jpg")

    def test_the_adapted_window_leaves_no_poor_view(self, fits):
        assert fits[None].rms_px < 0.5 * fits[11].rms_px
        assert fits[None].advice.drop == ()

    def test_the_pose_of_the_first_view_is_upright(self, fits):
        assert np.all(np.diag(rotations_of(fits[11].poses)[0]) * [-1, -1, 1] > 0.9)
