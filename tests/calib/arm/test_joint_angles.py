from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from armtwin.calib.arm import least_squares
from armtwin.calib.arm.evaluation import joint_error_rms
from armtwin.models.arm import nominal_arm
from armtwin.models.errors import InputError
from armtwin.models.recordings.reader import read_recording
from armtwin.models.recordings.recording import Recording

DATA = Path(__file__).resolve().parents[3].parent / "shared" / "data" / "brachiograph"
ZEROS = np.array([0.02, -0.03, 0.08])


def angles(noise_rad: float, n: int = 50, seed: int = 0) -> Recording:
    rng = np.random.default_rng(seed)
    q = rng.uniform(-1, 1, (n, 3))
    return Recording(
        arm=nominal_arm(),
        sample=np.arange(n),
        time_s=np.full(n, np.nan),
        trajectory=np.full(n, "sweep"),
        q_cmd=q,
        q_meas=q + ZEROS + rng.normal(0, noise_rad, (n, 3)),
    )


def test_the_joint_zeros_are_found_from_measured_angles_alone():
    found = least_squares.calibrate(angles(1e-3))
    assert found.method == "joint-angles"
    assert found.names == ("delta_theta1_rad", "delta_theta2_rad", "delta_theta3_rad")
    assert (np.abs(found.deviation.joints_rad - ZEROS) < 4 * found.std).all()
    assert found.noise == pytest.approx(1e-3, rel=0.2)


def test_lengths_stay_as_drawn_and_the_report_says_so():
    found = least_squares.calibrate(angles(1e-3))
    np.testing.assert_array_equal(found.deviation.lengths_mm, 0.0)
    assert "delta_l1_mm, delta_l2_mm, delta_l4_mm, delta_l5_mm" in found.ties[0]
    assert found.base_in_board_mm is None


def test_a_slipped_reading_is_left_out_and_named():
    recording = angles(1e-3)
    recording.q_meas[7, 1] += 0.5
    found = least_squares.calibrate(recording)
    assert [(o.sample, o.marker) for o in found.outliers] == [(7, "theta2")]
    assert found.outliers[0].residual == pytest.approx(0.5, abs=0.01)


def test_the_intervals_hold_the_truth_in_92_to_98_percent_of_200_worlds():
    hits = np.zeros(3)
    for world in range(200):
        low, high = least_squares.calibrate(angles(1e-2, n=30, seed=world)).intervals95.T
        hits += (low <= ZEROS) & (high >= ZEROS)
    assert ((hits / 200 >= 0.92) & (hits / 200 <= 0.98)).all()


def test_missing_angles_are_skipped_and_a_joint_without_two_is_refused():
    recording = angles(1e-3)
    recording.q_meas[:30, 2] = np.nan
    assert least_squares.calibrate(recording).n_used == 2 * 50 + 20
    recording.q_meas[1:, 2] = np.nan
    with pytest.raises(InputError, match="0 poses with a measurement"):
        least_squares.calibrate(recording)


def test_a_recording_of_neither_markers_nor_angles_is_refused():
    with pytest.raises(InputError, match="nothing to calibrate on"):
        least_squares.calibrate(replace(angles(0.0), q_meas=None))


@pytest.mark.skipif(not DATA.is_dir(), reason="the BrachioGraph measurements are not beside the repository")
@pytest.mark.parametrize("joint", ["shoulder", "elbow"])
def test_a_real_servo_arms_protractor_readings_are_nearer_to_the_calibrated_arm(joint):
    recording = read_recording(DATA / joint)
    found = least_squares.calibrate(recording)
    rows = np.arange(len(recording))
    before = joint_error_rms(recording, rows)
    after = joint_error_rms(recording, rows, found.deviation)
    assert after < 0.5 * before
