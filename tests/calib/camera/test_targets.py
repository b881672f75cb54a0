"""ChArUco boards and grids of circles are found in pictures whose truth is known, in large ones too."""

import time
from dataclasses import replace

import cv2
import numpy as np
import pytest

from armtwin.calib.camera import Board, calibrate_camera, find_corners
from armtwin.calib.camera.charuco import DICTIONARIES, CharucoTarget, dictionary_seen
from armtwin.calib.camera.circles import CircleGrid, centred
from armtwin.models.camera import project
from armtwin.models.errors import InputError

K = np.array([[900.0, 0.0, 644.0], [0.0, 900.0, 355.0], [0.0, 0.0, 1.0]])
SIZE = (1280, 720)
TILTS = [(0.0, 0.1, 0.0), (0.5, 0.0, 0.1), (-0.5, 0.1, 0.0), (0.1, 0.5, -0.1), (0.0, -0.5, 0.2)]
CHARUCO = CharucoTarget(7, 5, 30.0, "4x4_50")


def seen(flat: np.ndarray, px_per_mm: float, origin_px: tuple[float, float], target, tilt, scale: float = 1.0):
    """A flat picture of a board through a pinhole, and the (N, 2) pixels of the target's points.

    `origin_px` is where the board frame's origin lies in the flat picture.
    """
    R = cv2.Rodrigues(np.array(tilt, float))[0]
    t = np.array([0.0, 0.0, 420.0]) - R @ target.points_mm.mean(axis=0)
    camera = np.diag([scale, scale, 1.0]) @ K
    to_mm = np.array(
        [[1 / px_per_mm, 0, -origin_px[0] / px_per_mm], [0, 1 / px_per_mm, -origin_px[1] / px_per_mm], [0, 0, 1]]
    )
    H = camera @ np.column_stack([R[:, 0], R[:, 1], t]) @ to_mm
    fine = 2
    finer = np.array([[fine, 0, (fine - 1) / 2], [0, fine, (fine - 1) / 2], [0, 0, 1.0]])
    size = (int(SIZE[0] * scale), int(SIZE[1] * scale))
    large = cv2.warpPerspective(flat, finer @ H, (size[0] * fine, size[1] * fine), borderValue=210)
    picture = cv2.GaussianBlur(cv2.resize(large, size, interpolation=cv2.INTER_AREA), (0, 0), 0.7 * scale)
    X = target.points_mm @ R.T + t
    pixels = X @ camera.T
    return picture, pixels[:, :2] / pixels[:, 2:]


def charuco_picture(tilt, scale=1.0):
    per_square = 120
    markers = cv2.aruco.getPredefinedDictionary(DICTIONARIES[CHARUCO.dictionary])
    made = cv2.aruco.CharucoBoard((7, 5), 30.0, 22.5, markers)
    flat = made.generateImage((7 * per_square, 5 * per_square), marginSize=0)
    margin = 60
    flat = cv2.copyMakeBorder(flat, margin, margin, margin, margin, cv2.BORDER_CONSTANT, value=210)
    # The first inner corner lies between the first two squares; pixel centres are whole numbers.
    origin = margin + per_square - 0.5
    return seen(flat, per_square / 30.0, (origin, origin), CHARUCO, tilt, scale)


def circle_picture(grid: CircleGrid, tilt):
    px_per_mm, margin = 4.0, 120
    points = grid.points_mm[:, :2] * px_per_mm + margin
    width, height = (points.max(axis=0) + margin).astype(int)
    flat = np.full((height, width), 210, np.uint8)
    for x, y in points:
        cv2.circle(
            flat, (round(x * 16), round(y * 16)), round(0.3 * grid.square_mm * px_per_mm * 16), 30, -1, cv2.LINE_AA, 4
        )
    return seen(flat, px_per_mm, (margin, margin), grid, tilt)


@pytest.mark.parametrize("tilt", TILTS)
def test_a_charuco_boards_corners_are_where_they_are(tilt):
    picture, truth = charuco_picture(tilt)
    view = CHARUCO.find("a", picture)
    assert view is not None
    assert len(view.ids) == CHARUCO.n_corners
    np.testing.assert_allclose(view.pixels, truth[view.ids], atol=0.12)


def test_a_part_of_a_charuco_board_serves(tmp_path):
    views = []
    for i, tilt in enumerate(TILTS):
        picture, _ = charuco_picture(tilt)
        picture[:, : 500 + 20 * i] = 210  # a hand over the left of it
        view = CHARUCO.find(f"view {i}", picture)
        assert view is not None
        assert 8 <= len(view.ids) < CHARUCO.n_corners
        views.append(view)
    views += [replace(CHARUCO.find("whole", charuco_picture(t)[0]), name=f"whole {t}") for t in TILTS]
    fit = calibrate_camera(views, CHARUCO, SIZE)
    np.testing.assert_allclose(fit.camera.K, K, atol=4.0)
    assert fit.camera.R_board_camera[1, 1] < 0.0  # y up in the picture, as the frame of the bench has it


def test_corners_of_a_large_photograph_are_found_in_a_small_one_and_refined_in_the_large():
    picture, truth = charuco_picture(TILTS[1], scale=3.0)
    assert picture.shape == (2160, 3840)
    view = CHARUCO.find("a", picture)
    np.testing.assert_allclose(view.pixels, truth[view.ids], atol=0.25)


@pytest.mark.parametrize("grid", [CircleGrid(7, 5, 30.0), CircleGrid(4, 9, 20.0, staggered=True)], ids=str)
def test_circles_are_found_and_give_the_camera(grid):
    views, truths = [], []
    for i, tilt in enumerate(TILTS):
        picture, truth = circle_picture(grid, tilt)
        view = grid.find(f"view {i}", picture)
        assert view is not None
        away = np.linalg.norm(view.pixels[:, None] - truth[None], axis=-1)
        # The middle of a tilted circle's picture is off the picture of its middle by tenths of a pixel at this size.
        assert away.min(axis=1).max() < 0.3
        assert view.radius_mm == pytest.approx(0.3 * grid.square_mm, rel=0.03)
        views.append(view)
        truths.append(truth)
    views = centred(calibrate_camera(views, grid, SIZE))
    for view, truth in zip(views, truths, strict=True):
        assert np.linalg.norm(view.pixels[:, None] - truth[None], axis=-1).min(axis=1).max() < 0.05
    fit = calibrate_camera(views, grid, SIZE)
    np.testing.assert_allclose(fit.camera.K[[0, 1], [0, 1]], 900.0, rtol=0.0005)
    assert fit.rms_px < 0.02
    assert fit.camera.R_board_camera[1, 1] < 0.0


def test_twelve_megapixels_of_clutter_take_seconds():
    rng = np.random.default_rng(0)
    noise = cv2.GaussianBlur(rng.integers(0, 255, (3000, 4000), dtype=np.uint8), (0, 0), 3.0)
    begun = time.process_time()
    assert find_corners(noise, Board(9, 6, 23.0)) is None
    assert CircleGrid(7, 5, 30.0).find("a", noise) is None
    assert time.process_time() - begun < 20.0  # 118 s where it was searched whole


def test_a_chessboard_in_twelve_megapixels_is_found_and_refined_in_the_whole_picture(photograph, small_camera, board):
    scale = 8
    picture = cv2.resize(photograph(small_camera, board), None, fx=scale, fy=scale, interpolation=cv2.INTER_CUBIC)
    assert picture.size > 10_000_000
    found = find_corners(picture, board)
    assert found is not None
    truth = (project(small_camera, board.points_mm) + 0.5) * scale - 0.5
    np.testing.assert_allclose(found, truth, atol=0.1 * scale)


def test_a_pattern_of_an_older_opencv_is_found_too():
    old = CharucoTarget(7, 6, 30.0, "4x4_50")
    made = cv2.aruco.CharucoBoard((7, 6), 30.0, 22.5, cv2.aruco.getPredefinedDictionary(DICTIONARIES["4x4_50"]))
    made.setLegacyPattern(True)
    view = old.find("a", made.generateImage((700, 600), marginSize=20))
    assert view is not None
    assert len(view.ids) == old.n_corners


def test_the_markers_dictionary_is_told():
    assert dictionary_seen(charuco_picture(TILTS[0])[0]) == "4x4_50"
    assert dictionary_seen(np.full((480, 640), 128, np.uint8)) is None


def test_a_board_that_no_maker_has_is_refused():
    with pytest.raises(InputError, match="did you mean"):
        CharucoTarget.parse("7x5", 30.0, "4x4_5O")
    with pytest.raises(InputError, match="--marker-mm: found 40"):
        CharucoTarget.parse("7x5", 30.0, "4x4_50", 40.0)
    with pytest.raises(InputError, match="columns x rows of circles"):
        CircleGrid.parse("seven", 30.0, False)
