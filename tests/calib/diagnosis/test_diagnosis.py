"""Verdicts, ties, uncertainty, geometry and the held-out gain of whole diagnoses."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from armtwin.calib.diagnosis.diagnosis import diagnose
from armtwin.calib.diagnosis.experiment import propose
from armtwin.models.camera import project
from armtwin.models.camera_files import nominal_camera
from armtwin.models.coordinate_frames import robot_to_board
from armtwin.models.errors import RecordingError
from armtwin.models.kinematics import marker_positions
from armtwin.models.lenses import Equidistant
from armtwin.models.recordings.reader import read_recording
from armtwin.models.recordings.writer import write_recording
from tests.support.recordings import BASE_MM, DEVIATION, gain_of, recording, waves


def test_a_world_without_effects_has_no_cause_and_the_twin_meets_the_noise() -> None:
    diagnosis = diagnose(recording())
    assert diagnosis.verdict == "none"
    assert diagnosis.causes == ()
    assert diagnosis.held_out.after_rms_mm == pytest.approx(diagnosis.held_out.noise_floor_mm, rel=0.15)


def test_a_wrong_gain_is_named_with_its_joint_its_size_and_its_gain_on_unseen_poses() -> None:
    diagnosis = diagnose(recording(gain_of(2, 1.03)))
    cause = diagnosis.causes[0]
    assert (cause.active.effect.name, cause.active.site.joint) == ("servo_gain", 2)
    assert abs(cause.active.values[0] - 1.03) < 3 * cause.std[0]
    assert cause.p_value < 1e-6
    assert diagnosis.held_out.gain_percent > 80
    assert diagnosis.held_out.gain_ci95_percent[0] < diagnosis.held_out.gain_percent


def test_an_arm_seen_through_a_fisheye_is_diagnosed_like_any_other(tmp_path: Path) -> None:
    fisheye = replace(nominal_camera(), lens=Equidistant(np.array([0.03, 0.01, -0.01, 0.001])))
    write_recording(tmp_path, recording(gain_of(2, 1.03), camera=fisheye))
    read = read_recording(tmp_path)
    assert read.camera is not None
    assert isinstance(read.camera.lens, Equidistant)
    (cause,) = diagnose(read).causes
    assert (cause.active.effect.name, cause.active.site.joint) == ("servo_gain", 2)
    assert abs(cause.active.values[0] - 1.03) < 3 * cause.std[0]


def test_a_fisheye_whose_coefficients_are_off_is_named() -> None:
    true = Equidistant(np.array([0.03, 0.01, -0.01, 0.001]))
    made = recording(camera=replace(nominal_camera(), lens=true.changed(np.array([0.15, 0.0, 0.0, 0.0]))))
    assert made.camera is not None
    diagnosis = diagnose(replace(made, camera=replace(made.camera, lens=true)))
    assert "lens_distortion" in [cause.active.effect.name for cause in diagnosis.causes]


def test_what_no_effect_explains_is_unknown_and_says_what_it_follows() -> None:
    rng = np.random.default_rng(5)
    walk = np.cumsum(rng.normal(0.0, 0.004, 120))
    walk -= np.linspace(walk[0], walk[-1], 120)

    def wander(q: np.ndarray) -> np.ndarray:
        out = q.copy()
        out[:, 1] += walk * np.sin(np.arange(120) / 4.0)
        return out

    diagnosis = diagnose(recording(wander))
    assert diagnosis.verdict == "unknown"
    assert diagnosis.causes == ()
    assert diagnosis.trends_after


def test_noise_far_above_what_is_declared_is_not_called_none() -> None:
    made = replace(recording(noise_px=0.3), pixel_noise_px=0.05)
    assert diagnose(made).verdict == "unknown"


def test_undeclared_noise_of_any_size_is_no_cause() -> None:
    assert diagnose(recording(noise_px=0.4, declare_noise=False)).verdict == "none"


def test_a_tilted_camera_and_a_tilted_first_axis_are_a_tie() -> None:
    made = recording()
    turn = np.array([[1.0, 0.0, 0.02], [0.0, 1.0, 0.0], [-0.02, 0.0, 1.0]])
    turn, _ = np.linalg.qr(turn)
    turn *= np.sign(np.diag(turn))
    tilted = nominal_camera().moved(turn, np.zeros(3))
    points = marker_positions(made.arm, made.q_cmd, DEVIATION)
    pixels = project(tilted, robot_to_board(points.reshape(-1, 2), BASE_MM)).reshape(points.shape)
    pixels += np.random.default_rng(0).normal(0.0, 0.05, pixels.shape)
    diagnosis = diagnose(replace(made, markers_px={m: pixels[:, k] for k, m in enumerate("abcf")}))
    assert diagnosis.verdict == "ambiguous"
    names = {diagnosis.causes[0].active.effect.name, *(e.effect.name for e in diagnosis.causes[0].equivalents)}
    assert {"camera_tilt", "axis_tilt"} <= names


def test_six_parameters_of_seven_are_known_and_the_plane_is_gauge() -> None:
    geometry = diagnose(recording()).geometry
    assert geometry.identifiable == 6
    assert any(text.startswith("plane_offset") for text in geometry.gauge)
    np.testing.assert_allclose(geometry.deviation.lengths_mm[:2], DEVIATION.lengths_mm[:2], atol=0.05)
    np.testing.assert_allclose(geometry.base_in_board_mm, BASE_MM, atol=0.1)


def test_held_out_poses_change_no_estimate() -> None:
    made = recording(gain_of(2, 1.03))
    held = made.trajectory == "wave_3"
    moved = {name: np.where(held[:, None], pixels + 5.0, pixels) for name, pixels in made.markers_px.items()}
    plain, spoiled = diagnose(made), diagnose(replace(made, markers_px=moved))
    np.testing.assert_allclose(plain.causes[0].active.values, spoiled.causes[0].active.values, rtol=1e-6)
    assert spoiled.held_out.after_rms_mm > 10 * plain.held_out.after_rms_mm


def test_what_only_held_out_poses_show_is_unknown_and_what_they_would_show_if_fitted_comes_nearest() -> None:
    made = recording(lambda q: q + np.where(np.arange(len(q)) >= 100, 0.01, 0.0)[:, None] * [0.0, 1.0, 0.0])
    assert set(made.trajectory[100:]) <= set(made.held_out)
    diagnosis = diagnose(made)
    assert diagnosis.verdict == "unknown"
    assert [trend.against for trend in diagnosis.trends_after] == ["the poses held out"]
    assert [(c.active.effect.name, c.active.site.joint) for c in diagnosis.suspects] == [("joint_slip", 2)]
    assert diagnosis.explanation.final.effects == ()
    assert propose(diagnosis) is None


def test_measured_angles_alone_can_be_diagnosed() -> None:
    made = recording()
    bent = gain_of(1, 1.05)(made.q_cmd) + np.random.default_rng(0).normal(0.0, 0.002, made.q_cmd.shape)
    diagnosis = diagnose(replace(made, markers_px={}, camera=None, q_meas=bent))
    assert (diagnosis.causes[0].active.effect.name, diagnosis.causes[0].active.site.joint) == ("servo_gain", 1)


def test_too_few_poses_are_refused_with_how_many_are_missing() -> None:
    with pytest.raises(RecordingError, match=r"too short to decide.*add at least \d+ poses"):
        diagnose(recording(paths=waves(1, 3), markers="f"))


def test_an_arm_at_rest_is_refused() -> None:
    with pytest.raises(RecordingError, match="never change"):
        diagnose(recording(paths={"still": np.tile([0.1, 0.2, 0.3], (40, 1))}))


def test_a_recording_that_holds_out_everything_is_refused() -> None:
    with pytest.raises(RecordingError, match="held_out names every trajectory"):
        diagnose(recording(paths=waves(2, 20), held_out=("wave_0", "wave_1")))


def test_marker_a_alone_is_refused() -> None:
    with pytest.raises(RecordingError, match="only marker A"):
        diagnose(recording(markers="a"))
