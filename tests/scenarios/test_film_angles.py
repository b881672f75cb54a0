from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from armtwin.models.arm import nominal_arm
from armtwin.models.camera import project
from armtwin.models.camera_files import nominal_camera
from armtwin.models.coordinate_frames import robot_to_board
from armtwin.models.errors import RecordingError
from armtwin.models.kinematics import Deviation, marker_positions
from armtwin.models.recordings.moving_reader import read_moving
from armtwin.models.recordings.recording import Recording, make_samples
from armtwin.scenarios.film_angles import angles_of_film, write_moving

PLANE_MM = -80.87
N = 80


def film() -> tuple[Recording, np.ndarray]:
    """Pictures of an arm that swings, with lengths other than drawn, and the angles that it had."""
    arm, camera = nominal_arm(), nominal_camera()
    time_s = np.arange(N) / 25.0
    q = 0.3 * np.sin(time_s[:, None] * np.array([2.0, 3.0, 4.0]))
    longer = Deviation(np.array([3.0, -2.0, 0.0, 0.0]), np.zeros(3))
    points = marker_positions(arm, q, longer)
    base = np.array([40.0, -33.0, PLANE_MM])
    pixels = project(camera, robot_to_board(points, base).reshape(-1, 3)).reshape(N, -1, 2)
    markers = {name: pixels[:, k] for k, name in enumerate(arm.marker_names)}
    commands = np.roll(q, -2, axis=0)
    names = np.full(N, "swing")
    return Recording(
        arm, make_samples(N), time_s, names, commands, markers, None, time_s, None, None, camera, PLANE_MM
    ), q


def test_a_film_shows_the_angles_of_the_joints_whatever_the_lengths() -> None:
    seen, q = film()
    np.testing.assert_allclose(angles_of_film(seen).q_meas, q, atol=1e-9)


def test_a_picture_with_a_hidden_marker_has_no_angles() -> None:
    seen, _ = film()
    seen.markers_px["b"][3] = np.nan
    angles = angles_of_film(seen).q_meas
    assert angles is not None
    assert np.isnan(angles[3]).all()
    assert np.isfinite(np.delete(angles, 3, axis=0)).all()


def test_what_is_written_is_a_moving_recording(tmp_path: Path) -> None:
    seen, q = film()
    write_moving(tmp_path, angles_of_film(seen))
    back = read_moving(tmp_path)
    np.testing.assert_allclose(back.q_meas, q, atol=1e-9)
    np.testing.assert_array_equal(back.time_s, seen.time_s)


def test_a_film_without_its_camera_is_refused() -> None:
    seen, _ = film()
    with pytest.raises(RecordingError, match="camera"):
        angles_of_film(replace(seen, camera=None))
