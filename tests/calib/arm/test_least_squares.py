from dataclasses import replace

import numpy as np
import pytest

from armtwin.calib.arm import least_squares
from armtwin.calib.arm.chain import Chain
from armtwin.models.arm import Arm, nominal_arm
from armtwin.models.kinematics import Deviation, forward, inverse
from armtwin.models.trajectories import paper_trajectories

VARIED = np.random.default_rng(1).uniform(-0.6, 0.6, (40, 3))


@pytest.mark.parametrize("markers", ["abcf", "af", "cf", "bcf", "fa", "abcef"])
def test_noiseless_pixels_give_back_the_injected_geometry_and_base(simulate, table_4_deviation, markers):
    recording = simulate(delta=table_4_deviation, markers=markers, q_cmd=VARIED)
    found = least_squares.calibrate(recording)
    truth = table_4_deviation if "e" in markers else Chain(recording.arm).in_convention(table_4_deviation)
    np.testing.assert_allclose(found.deviation.lengths_mm, truth.lengths_mm, atol=1e-6)
    np.testing.assert_allclose(found.deviation.joints_rad, truth.joints_rad, atol=1e-8)
    np.testing.assert_allclose(found.base_in_board_mm, [-35.0, -20.0, -80.87], atol=1e-6)
    assert found.rms_px < 1e-6
    assert found.outliers == ()


def test_marker_f_alone_is_enough_in_varied_poses(simulate, table_4_deviation):
    recording = simulate(delta=table_4_deviation, markers="f", q_cmd=VARIED)
    found = least_squares.calibrate(recording)
    truth = Chain(recording.arm).in_convention(table_4_deviation)
    assert found.identifiable == 6
    np.testing.assert_allclose(found.deviation.lengths_mm, truth.lengths_mm, atol=1e-6)
    np.testing.assert_allclose(found.base_in_board_mm[:2], [-35.0, -20.0], atol=1e-6)


@pytest.mark.parametrize("n_joints", [1, 2, 4, 6])
def test_chains_of_other_lengths_are_calibrated_on_all_their_markers(simulate, n_joints):
    rng = np.random.default_rng(n_joints)
    arm = Arm("plain", rng.uniform(20, 60, n_joints), np.zeros(2))
    truth = Deviation(rng.normal(0, 2, n_joints), rng.normal(0, 0.05, n_joints))
    recording = simulate(
        arm=arm, delta=truth, q_cmd=rng.uniform(-0.8, 0.8, (30, n_joints)), markers="".join(arm.marker_names)
    )
    found = least_squares.calibrate(recording)
    assert found.identifiable == 2 * n_joints
    np.testing.assert_allclose(found.deviation.lengths_mm, truth.lengths_mm, atol=1e-6)
    np.testing.assert_allclose(found.deviation.joints_rad, truth.joints_rad, atol=1e-8)


def test_the_jacobian_is_that_of_central_differences(simulate, table_4_deviation):
    recording = simulate(markers="abcef", delta=table_4_deviation)
    chain = Chain(recording.arm)
    seen = least_squares.observe(recording, np.arange(0, 150, 10))
    problem = least_squares._Problem(chain, seen, recording.camera, recording.arm_plane_z_mm)
    x = np.array([5.0, 4.0, -1.0, 0.5, 0.02, -0.03, 0.1, -30.0, -25.0])
    _, J = problem.residuals(x)
    for k, step in enumerate([1e-4] * 4 + [1e-6] * 3 + [1e-4] * 2):
        h = np.eye(9)[k] * step
        difference = -(problem.residuals(x + h)[0] - problem.residuals(x - h)[0]) / (2 * step)
        np.testing.assert_allclose(J[..., k], difference, rtol=1e-6, atol=1e-6)


def test_gross_errors_are_left_out_and_named(simulate, table_4_deviation):
    recording = simulate(delta=table_4_deviation, noise_px=0.06, seed=1)
    rng = np.random.default_rng(2)
    wrong = sorted(rng.choice(150, 25, replace=False))
    recording.markers_px["f"][wrong] += rng.uniform(20, 300, (25, 2))
    found = least_squares.calibrate(recording)
    clean = least_squares.calibrate(simulate(delta=table_4_deviation, noise_px=0.06, seed=1))
    assert [(o.sample, o.marker) for o in found.outliers] == [(int(k), "f") for k in wrong]
    assert (np.abs(found.values - clean.values) < 2.0 * clean.std).all()


def test_markers_taken_for_each_other_in_some_frames_are_left_out(simulate, table_4_deviation):
    recording = simulate(delta=table_4_deviation, noise_px=0.06, seed=1)
    swapped = np.arange(5, 150, 10)
    b, c = recording.markers_px["b"], recording.markers_px["c"]
    b[swapped], c[swapped] = c[swapped].copy(), b[swapped].copy()
    found = least_squares.calibrate(recording)
    assert {(o.sample, o.marker) for o in found.outliers} == {(int(k), m) for k in swapped for m in "bc"}
    np.testing.assert_allclose(found.deviation.lengths_mm[:2], [6.7015, 4.5704], atol=0.02)


def test_unseen_markers_are_skipped(simulate, table_4_deviation):
    recording = simulate(delta=table_4_deviation, noise_px=0.06)
    hidden = np.random.default_rng(3).random((4, 150)) < 0.3
    for pixels, gone in zip(recording.markers_px.values(), hidden, strict=True):
        pixels[gone] = np.nan
    found = least_squares.calibrate(recording)
    assert found.n_used == int((~hidden).sum())
    np.testing.assert_allclose(found.deviation.lengths_mm[:2], [6.7015, 4.5704], atol=0.02)


def test_the_noise_is_found_from_the_residuals(simulate):
    found = least_squares.calibrate(simulate(noise_px=0.06))
    assert found.noise == pytest.approx(0.06, rel=0.1)
    assert found.degrees_of_freedom == 2 * 600 - 8
    assert found.rms_px == pytest.approx(0.06 * np.sqrt(2), rel=0.1)


def test_when_play_shakes_all_markers_of_a_pose_the_clustered_deviations_tell_the_true_spread(simulate):
    commands = simulate().q_cmd
    estimates, model, clustered = [], [], []
    for world in range(100):
        play = np.random.default_rng(world).normal(0, 5e-3, (150, 1)) * np.array([0.0, 1.0, 0.0])
        shaken = simulate(q_cmd=commands + play, noise_px=0.06, seed=world)
        found = least_squares.calibrate(replace(shaken, q_cmd=commands))  # the commands do not know of the play
        assert len(found.outliers) < 0.01 * found.n_used  # what shakes a whole arm is no gross error
        estimates.append(found.values[5])
        model.append(found.std[5])
        clustered.append(found.clustered_std[5])
    spread = np.std(estimates)
    assert np.mean(clustered) == pytest.approx(spread, rel=0.2)
    assert abs(np.mean(clustered) - spread) < abs(np.mean(model) - spread)


def test_a_rescaled_noise_rescales_the_standard_deviations(simulate):
    fine = least_squares.calibrate(simulate(noise_px=0.02, seed=4))
    coarse = least_squares.calibrate(simulate(noise_px=0.2, seed=4))
    np.testing.assert_allclose(coarse.std / fine.std, 10.0, rtol=0.02)


def test_the_corrected_inverse_kinematics_brings_the_built_arm_onto_the_line(simulate, table_4_deviation):
    arm = nominal_arm()
    found = least_squares.calibrate(simulate(delta=table_4_deviation, noise_px=0.06, held_out=("line",)))
    line = paper_trajectories()["line"]
    before = forward(arm, inverse(arm, line), table_4_deviation)
    after = forward(arm, inverse(arm, line, delta=found.deviation), table_4_deviation)
    assert np.linalg.norm(before - line, axis=1)[0] > 1.0
    assert np.linalg.norm((after - line)[:, :2], axis=1).max() < 0.02


def test_the_order_of_the_rows_does_not_matter(simulate, table_4_deviation):
    recording = simulate(delta=table_4_deviation, noise_px=0.06)
    forward_found = least_squares.calibrate(recording)
    order = np.random.default_rng(0).permutation(150)
    shuffled = simulate(delta=table_4_deviation, q_cmd=recording.q_cmd[order])
    shuffled.markers_px.update({name: px[order] for name, px in recording.markers_px.items()})
    found = least_squares.calibrate(shuffled)
    np.testing.assert_allclose(found.values, forward_found.values, atol=1e-6)
