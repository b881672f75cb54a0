"""The page of a camera's calibration as a person opens it, and what it says of lenses."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from armtwin.calib.camera import Board, Corners
from armtwin.calib.camera.images import Found
from armtwin.models.camera import project
from armtwin.models.camera_files import nominal_camera
from armtwin.scenarios.camera_calibration.job import Views, calibrate_views
from armtwin.scenarios.camera_calibration.page import report_page
from armtwin.scenarios.runner.board_views import board_poses
from tests.support.browser import CHROMIUM, DESK_PX, PHONE_PX, chromium, faults_of

BOARD = Board(9, 6, 23.0)


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Eight views of the board through the nominal webcam, with 0.1 px of noise."""
    camera, rng = nominal_camera(), np.random.default_rng(0)
    outer = np.array([[-23.0, -23, 0], [207, -23, 0], [207, 138, 0], [-23, 138, 0]])
    views = []
    for i, pose in enumerate(board_poses(camera, outer, 8, rng)):
        points = BOARD.points_mm @ pose[:3, :3].T + pose[:3, 3]
        views.append(Corners(f"photograph-{i}.jpg", project(camera, points) + rng.normal(0.0, 0.1, (54, 2))))
    seen = Views(BOARD, tuple(views), (1280, 720), ("wall.jpg",), (), ("passed over: notes.txt is no photograph",))
    file = tmp_path_factory.mktemp("page") / "camera.html"
    file.write_text(report_page(calibrate_views(seen, Found())), "utf-8")
    return file


def test_it_compares_the_lenses_and_says_what_was_passed_over(page: Path) -> None:
    text = page.read_text("utf-8")
    for part in ("Which lens it is", "equidistant", "plumb_bob_bowed_board", "best: an ordinary lens"):
        assert part in text
    assert "passed over: notes.txt is no photograph" in text
    assert "the whole board was not found: wall.jpg" in text


@pytest.mark.skipif(CHROMIUM is None, reason="no Chromium on this machine")
@pytest.mark.xdist_group("browser")
def test_it_is_whole_at_a_desk_and_on_a_phone(page: Path) -> None:
    with chromium() as browser:
        assert faults_of(browser, page, DESK_PX) == []
        assert faults_of(browser, page, PHONE_PX) == []
