"""What is wrong with the camera, the stickers and their detection; and axes that are not square to the picture."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from armtwin.models.camera import project
from armtwin.models.coordinate_frames import robot_to_board
from armtwin.models.errors import InputError
from armtwin.models.lenses import Equidistant
from armtwin.models.world import World
from armtwin.sim.observe import make_recording, pixels_of
from armtwin.sim.physics.simulation import ArmSimulation, simulate
from tests.support.worlds import PLANE_MM, errors_rad, flat_world, scattered, with_effect

N = 8
Q = scattered(N)
CLOCK = np.arange(N, dtype=float)


def pixels(world: World) -> dict[str, np.ndarray]:
    return pixels_of(world, simulate(world, Q, CLOCK), CLOCK)


def shift(name: str, parameters: dict[str, Any], marker: str | None = None) -> dict[str, np.ndarray]:
    """(N, 2) px by which an effect moves each marker."""
    without = pixels(flat_world())
    return {m: p - without[m] for m, p in pixels(with_effect(flat_world(), name, parameters, marker=marker)).items()}


def test_a_fisheye_is_changed_by_its_own_coefficients() -> None:
    lens = Equidistant(np.array([0.03, 0.01, -0.01, 0.001]))
    world = flat_world()
    fisheye = replace(world, true_camera=replace(world.true_camera, lens=lens))
    changed = with_effect(fisheye, "lens_distortion", {"k4": 0.02}).true_camera.lens
    np.testing.assert_allclose(changed.coefficients - lens.coefficients, [0.0, 0.0, 0.0, 0.02], atol=1e-15)
    with pytest.raises(InputError, match="p1: the lens of this camera has k1, k2, k3, k4"):
        with_effect(fisheye, "lens_distortion", {"p1": 0.01})


def test_an_arm_farther_away_looks_smaller() -> None:
    farther, nearer = pixels(with_effect(flat_world(), "plane_offset", {"offset_mm": 10.0})), pixels(flat_world())
    ratio = np.linalg.norm(farther["b"] - farther["a"], axis=1) / np.linalg.norm(nearer["b"] - nearer["a"], axis=1)
    distance = 485.0  # of the arm's plane from the camera, mm
    np.testing.assert_allclose(ratio, distance / (distance + 10.0), rtol=0.01)


def test_a_tilt_about_x_moves_the_picture_along_v() -> None:
    moved = shift("camera_tilt", {"tilt_x_rad": 0.002})["a"]
    focal = flat_world().camera.K[1, 1]
    np.testing.assert_allclose(moved[:, 1], -0.002 * focal, rtol=0.1)
    assert np.abs(moved[:, 0]).max() < 0.3


def test_a_bump_moves_the_camera_from_its_sample_on() -> None:
    moved = shift("camera_moved", {"translation_x_mm": 1.0, "from_sample": 3})["a"]
    assert np.abs(moved[:3]).max() < 1e-9
    np.testing.assert_allclose(moved[3:, 0], 1438.6 / 485.0, rtol=0.05)


def test_a_creeping_camera_has_come_all_the_way_at_the_end() -> None:
    moved = shift("camera_drift", {"translation_x_mm": 1.0})["a"][:, 0]
    assert moved[0] == pytest.approx(0.0, abs=1e-9)
    assert (np.diff(moved) > 0).all()
    assert moved[-1] == pytest.approx(1438.6 / 485.0, rel=0.05)


def test_autofocus_scales_the_picture_about_its_principal_point() -> None:
    without, scaled = pixels(flat_world()), pixels(with_effect(flat_world(), "focal_length", {"scale": 1.02}))
    centre = flat_world().camera.K[:2, 2]
    np.testing.assert_allclose(scaled["f"] - centre, 1.02 * (without["f"] - centre), atol=1e-9)


def test_another_lens_distorts_most_far_from_the_middle() -> None:
    moved = shift("lens_distortion", {"k1": 0.05})
    centre = flat_world().camera.K[:2, 2]
    without = pixels(flat_world())
    radius = np.linalg.norm(without["a"] - centre, axis=1) / 1438.6
    np.testing.assert_allclose(np.linalg.norm(moved["a"], axis=1), 0.05 * 1438.6 * radius**3, rtol=0.15)


@pytest.mark.parametrize(("marker", "body", "link"), [("b", 0, "link1"), ("b", 1, "link2"), ("a", 1, "link1")])
def test_a_sticker_off_its_axis_turns_with_the_link_that_carries_it(marker: str, body: int, link: str) -> None:
    parameters = {"x_mm": 2.0, "y_mm": -1.0, "body": body}
    world = with_effect(flat_world(), "marker_offset", parameters, marker=marker)
    arm, true = ArmSimulation(world), ArmSimulation(flat_world())
    for q in Q[:3]:
        arm.move(q)
        true.move(q)
        index = arm.marker_names.index(marker)
        off = arm.markers_mm()[index] - true.markers_mm()[index]
        np.testing.assert_allclose(off, arm.bodies()[link][:3, :3] @ [2.0, -1.0, 0.0], atol=0.005)


def test_the_first_sticker_is_stuck_on_the_base() -> None:
    world = with_effect(flat_world(), "marker_offset", {"x_mm": 2.0, "y_mm": -1.0}, marker="a")
    np.testing.assert_allclose(simulate(world, Q)[:, 0], np.tile([2.0, -1.0, 0.0], (N, 1)), atol=1e-9)


def test_a_marker_that_the_arm_does_not_have_is_refused() -> None:
    with pytest.raises(InputError, match="marker: found 'q', one of a, b, c, e, f is wanted"):
        with_effect(flat_world(), "marker_offset", {"x_mm": 2.0, "y_mm": 0.0}, marker="q")


def record(world: World, seed: int = 0) -> dict[str, np.ndarray]:
    return make_recording(world, Q, ["t"] * N, CLOCK, np.random.default_rng(seed), 0.0).markers_px


def test_swapped_markers_trade_places_in_their_frames_only() -> None:
    world = with_effect(flat_world(), "marker_swap", {"samples": [2, 5], "other": "c"}, marker="b")
    swapped, true = record(world), record(flat_world())
    np.testing.assert_array_equal(swapped["b"][[2, 5]], true["c"][[2, 5]])
    np.testing.assert_array_equal(swapped["c"][[2, 5]], true["b"][[2, 5]])
    rest = [0, 1, 3, 4, 6, 7]
    np.testing.assert_array_equal(swapped["b"][rest], true["b"][rest])


def test_a_marker_is_not_swapped_with_itself() -> None:
    with pytest.raises(InputError, match="other: found 'b', which is the marker itself"):
        with_effect(flat_world(), "marker_swap", {"samples": [2], "other": "b"}, marker="b")


def test_of_a_marker_that_nobody_looks_for_nothing_is_swapped() -> None:
    world = with_effect(flat_world(), "marker_swap", {"samples": [2], "other": "e"}, marker="b")
    np.testing.assert_array_equal(record(world)["b"], record(flat_world())["b"])


def test_frames_beyond_the_recording_are_not_swapped() -> None:
    world = with_effect(flat_world(), "marker_swap", {"samples": [N + 3], "other": "c"}, marker="b")
    np.testing.assert_array_equal(record(world)["b"], record(flat_world())["b"])


def test_gross_errors_have_their_rate_and_size() -> None:
    world, true = with_effect(flat_world(), "outliers", {"rate": 0.25, "size_px": 20.0}), record(flat_world())
    off = np.concatenate(
        [np.linalg.norm(record(world, seed)[m] - true[m], axis=1) for seed in range(12) for m in "abcf"]
    )
    assert np.mean(off > 0) == pytest.approx(0.25, abs=0.08)
    assert off[off > 0].min() >= 10.0
    assert off.max() <= 30.0


def test_stale_pictures_show_earlier_poses() -> None:
    late = simulate(with_effect(flat_world(), "command_shift", {"rows": 2}), Q)
    true = simulate(flat_world(), Q)
    np.testing.assert_array_equal(late[2:], true[:-2])
    np.testing.assert_array_equal(late[:2], true[[0, 0]])


def test_later_pictures_show_later_poses() -> None:
    early = simulate(with_effect(flat_world(), "command_shift", {"rows": -1}), Q)
    np.testing.assert_array_equal(early[:-1], simulate(flat_world(), Q)[1:])


def test_a_tilted_axis_lifts_the_links_beyond_it_out_of_the_plane() -> None:
    world = with_effect(flat_world(), "axis_tilt", {"tilt_x_rad": 0.02, "tilt_y_rad": 0.0}, joint=1)
    q = np.array([[0.0, 0.0, 0.0], [0.5, 0.0, 0.0], [-0.5, 0.0, 0.0]])
    z = simulate(world, q)[:, 1, 2]
    assert z[0] == pytest.approx(0.0, abs=1e-4)
    # Marker B circles square to the axis (0, -sin, cos): it is 120 mm up the y axis at zero.
    expected = -120.0 * np.sin(0.02) * np.cos(0.02) * (np.cos(0.5) - 1.0)
    np.testing.assert_allclose(z[1:], -expected if z[1] * expected < 0 else expected, rtol=0.01)
    assert np.abs(z[1:]).min() > 0.1


def test_a_link_square_to_its_tilted_axis_leans_at_zero_too() -> None:
    world = with_effect(
        flat_world(), "axis_tilt", {"tilt_x_rad": 0.02, "tilt_y_rad": 0.0, "square_at_zero": 0}, joint=1
    )
    z = simulate(world, np.zeros((1, 3)))[0, 1, 2]
    assert z == pytest.approx(120.0 * np.sin(0.02), rel=0.01)


def test_a_tilted_axis_turns_by_the_commanded_angle() -> None:
    world = with_effect(flat_world(), "axis_tilt", {"tilt_x_rad": 0.02, "tilt_y_rad": 0.01}, joint=2)
    assert np.abs(errors_rad(world, Q)).max() < 5e-4  # second order in the tilt


def test_an_undisturbed_camera_sees_the_projection() -> None:
    points = robot_to_board(simulate(flat_world(), Q)[:, 0], np.array([40.0, -33.0, PLANE_MM]))
    np.testing.assert_allclose(pixels(flat_world())["a"], project(flat_world().camera, points), atol=1e-9)
