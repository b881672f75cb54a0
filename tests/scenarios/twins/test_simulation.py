"""A twin run through a plan, as a recording that reads back and shows what the twin is."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from armtwin.calib.arm import least_squares
from armtwin.models.arm import nominal_arm
from armtwin.models.camera_files import nominal_camera
from armtwin.models.errors import InputError
from armtwin.models.kinematics import Deviation
from armtwin.models.plan import Plan, paper_plan
from armtwin.models.recordings.reader import read_recording
from armtwin.models.twin import Twin
from armtwin.scenarios.twins.simulation import simulate, write_simulation

DEVIATION = Deviation(np.array([1.5, -2.0, 0.4, 0.0]), np.array([0.02, -0.03, 0.01]))
TWIN = Twin(nominal_arm(), DEVIATION, np.array([40.3, -33.2, -80.87]), nominal_camera(), ())
PLAN = paper_plan(nominal_arm())


def test_calibrating_the_simulated_recording_gives_the_twins_geometry_back(tmp_path: Path) -> None:
    write_simulation(tmp_path / "made", TWIN, PLAN, simulate(TWIN, PLAN, held_out=("line",)))
    read = read_recording(tmp_path / "made")
    assert read.held_out == ("line",)
    assert read.pixel_noise_px == 0.06
    found = least_squares.calibrate(read)
    np.testing.assert_allclose(found.deviation.lengths_mm[:2], DEVIATION.lengths_mm[:2], atol=0.1)
    np.testing.assert_allclose(found.base_in_board_mm[:2], [40.3, -33.2], atol=0.1)


def test_a_twin_of_joint_angles_alone_is_read_as_angles() -> None:
    made = simulate(Twin(nominal_arm(), DEVIATION, np.zeros(3), None, ()), PLAN, noise=0.0)
    assert made.camera is None
    assert made.q_meas is not None
    np.testing.assert_allclose(made.q_meas, PLAN.q_cmd + DEVIATION.joints_rad, atol=1e-5)


def test_the_pictures_show_the_markers_where_the_recording_has_them(tmp_path: Path) -> None:
    few = Plan(PLAN.trajectory[:2], PLAN.q_cmd[:2], PLAN.payload_kg[:2])
    made = simulate(TWIN, few, noise=0.0)
    write_simulation(tmp_path / "made", TWIN, few, made, frames=True)
    for row in range(2):
        frame = cv2.imread(str(tmp_path / "made" / "frames" / f"{row:06d}.png")).astype(float)
        u, v = np.rint(made.markers_px["f"][row]).astype(int)
        blue, _, red = frame[v, u]
        assert red > blue + 60  # the sticker is red


def test_pictures_of_a_twin_without_camera_are_refused(tmp_path: Path) -> None:
    blind = Twin(nominal_arm(), DEVIATION, np.zeros(3), None, ())
    with pytest.raises(InputError, match="has no camera"):
        write_simulation(tmp_path / "made", blind, PLAN, simulate(blind, PLAN), frames=True)
    assert not (tmp_path / "made").exists()
