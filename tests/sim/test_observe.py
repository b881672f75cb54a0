import numpy as np

from armtwin.models.camera import project
from armtwin.models.coordinate_frames import robot_to_board
from armtwin.models.kinematics import Deviation, marker_positions
from armtwin.sim.observe import make_angle_recording, make_recording, progress_of
from tests.support.worlds import flat_world, scattered, upright_world

NAMES = ["a"] * 6 + ["b"] * 4
Q = scattered(10)


def test_without_noise_the_pixels_are_the_projected_kinematics() -> None:
    deviation = Deviation(np.array([3.0, 0.0, 0.0, 0.0]), np.zeros(3))
    world = upright_world(deviation)
    recording = make_recording(world, Q, NAMES, None, np.random.default_rng(0), 0.0)
    points = marker_positions(world.arm, Q, deviation)
    for column, name in enumerate("abcf"):
        expected = project(world.camera, robot_to_board(points[:, column], world.base_in_board_mm))
        np.testing.assert_allclose(recording.markers_px[name], expected, atol=0.02)


def test_noise_has_the_standard_deviation_that_was_asked_for() -> None:
    clean = make_recording(flat_world(), Q, NAMES, None, np.random.default_rng(0), 0.0)
    noise = []
    for seed in range(20):
        noisy = make_recording(flat_world(), Q, NAMES, None, np.random.default_rng(seed), 0.2)
        noise += [noisy.markers_px[name] - clean.markers_px[name] for name in "abcf"]
    assert abs(np.std(noise) - 0.2) < 0.02


def test_the_recording_declares_the_drawing_not_the_truth() -> None:
    world = flat_world(Deviation(np.array([5.0, 0.0, 0.0, 0.0]), np.zeros(3)))
    recording = make_recording(world, Q, NAMES, None, np.random.default_rng(0), 0.1, held_out=("b",))
    np.testing.assert_array_equal(recording.arm.link_lengths_mm, [120.0, 121.7, 38.0, 6.73])
    assert recording.held_out == ("b",)
    assert recording.pixel_noise_px == 0.1


def test_missing_sightings_are_empty() -> None:
    recording = make_recording(flat_world(), Q, NAMES, None, np.random.default_rng(0), 0.1, missing=0.5)
    lost = np.isnan(recording.markers_px["f"]).all(axis=1)
    assert 0 < lost.sum() < len(Q)


def test_a_marker_outside_the_picture_is_not_seen() -> None:
    q = np.array([[0.0, 0.0, 0.0], [-2.0, 0.0, 0.0]])
    recording = make_recording(flat_world(), q, ["a", "a"], None, np.random.default_rng(0), 0.1)
    assert np.isfinite(recording.markers_px["c"][0]).all()
    assert np.isnan(recording.markers_px["c"][1]).all()


def test_only_the_markers_that_are_looked_for_are_recorded() -> None:
    recording = make_recording(flat_world(), Q, NAMES, None, np.random.default_rng(0), 0.1, markers=("a", "f"))
    assert set(recording.markers_px) == {"a", "f"}


def test_the_same_seed_gives_the_same_recording() -> None:
    one, two = (make_recording(flat_world(), Q, NAMES, None, np.random.default_rng(3), 0.1) for _ in range(2))
    for name in "abcf":
        np.testing.assert_array_equal(one.markers_px[name], two.markers_px[name])


def test_a_protractor_reads_the_horns_offsets_along() -> None:
    world = flat_world(Deviation(np.zeros(4), np.array([0.02, -0.03, 0.05])))
    recording = make_angle_recording(world, Q, NAMES, None, np.random.default_rng(0), 0.0)
    assert recording.q_meas is not None
    np.testing.assert_allclose(recording.q_meas - Q, np.tile([0.02, -0.03, 0.05], (10, 1)), atol=1e-5)
    assert recording.camera is None


def test_progress_runs_from_zero_to_one() -> None:
    np.testing.assert_allclose(progress_of(np.array([2.0, 3.0, 6.0])), [0.0, 0.25, 1.0])
