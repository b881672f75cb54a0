"""The calibration board and the gauges show in the picture where they are held, with their true sizes."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from armtwin.models.camera import back_project, project
from armtwin.models.errors import InputError
from armtwin.sim.render import (
    GAUGE_LENGTHS_MM,
    LensRenderer,
    chessboard_parts,
    facing_camera,
    gauge_disc_radius_mm,
    gauge_parts,
    panel_parts,
)
from tests.sim.render.cameras import webcam
from tests.sim.render.field import measured_centroid

# cornerSubPix itself is off by up to this on a board that fills the picture.
CORNER_PX = 0.2


def test_the_boards_inner_corners_are_found_where_they_project() -> None:
    camera = webcam(15.0)
    T = np.diag([-1.0, -1.0, 1.0, 1.0])
    T[:3, 3] = 92.0, 58.0, 30.0
    with LensRenderer(camera, chessboard_parts()) as renderer:
        grey = cv2.cvtColor(renderer.render({"board": T}), cv2.COLOR_BGR2GRAY)
    found, corners = cv2.findChessboardCornersSB(grey, (9, 6))
    assert found
    grid = 23.0 * np.stack(np.meshgrid(np.arange(9.0), np.arange(6.0)), axis=-1).reshape(-1, 2)
    points = np.column_stack([grid, np.zeros(54)]) @ T[:3, :3].T + T[:3, 3]
    expected = project(camera, points)
    distance = np.linalg.norm(corners.reshape(-1, 1, 2) - expected, axis=2)
    assert distance.min(axis=0).max() < CORNER_PX
    assert sorted(distance.argmin(axis=0)) == list(range(54))


@pytest.mark.parametrize("length_mm", GAUGE_LENGTHS_MM)
def test_a_gauges_targets_are_its_length_apart(length_mm: float) -> None:
    camera = webcam()
    T = facing_camera(13.0, -21.0, -80.87)
    turn = np.radians(33.0)
    T[:2, :2] = T[:2, :2] @ [[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]
    with LensRenderer(camera, [*panel_parts(), *gauge_parts(length_mm)], shadows=True) as renderer:
        red = renderer.render({"gauge": T})[..., 2]
    ends = T[:3, 3] + 0.5 * length_mm * np.array([[-1.0], [1.0]]) * T[:3, 0]
    reach = min(1.15 * gauge_disc_radius_mm(length_mm), 0.5 * length_mm)
    pixels = np.array([measured_centroid(camera, red, end, reach) for end in ends])
    measured = back_project(camera, pixels, -80.87)
    assert np.linalg.norm(measured[1] - measured[0]) == pytest.approx(length_mm, abs=0.005)


@pytest.mark.parametrize("length_mm", GAUGE_LENGTHS_MM)
def test_a_gauges_targets_do_not_touch(length_mm: float) -> None:
    assert 2.0 * gauge_disc_radius_mm(length_mm) < length_mm


def test_impossible_targets_are_refused() -> None:
    with pytest.raises(InputError, match=r"0\.0 mm"):
        gauge_parts(0.0)
    with pytest.raises(InputError, match="2 x 7"):
        chessboard_parts(2, 7)
    with pytest.raises(InputError, match=r"-1\.0"):
        chessboard_parts(square_mm=-1.0)
