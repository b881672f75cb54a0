"""Set-ups that are wrong grossly: each is found, told in a sentence, and mended; right ones are left alone."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest

from armtwin.calib.setup.screen import screen
from armtwin.models.arm import Arm, nominal_arm
from armtwin.models.camera import project
from armtwin.models.camera_files import nominal_camera
from armtwin.models.coordinate_frames import robot_to_board
from armtwin.models.kinematics import Deviation, marker_positions
from armtwin.models.recordings.recording import Recording, make_samples

ARMS = {
    "planar3": nominal_arm(),
    "two": Arm("two", np.array([110.0, 90.0]), np.zeros(2)),
    "four": Arm("four", np.array([50.0, 42.0, 30.0, 21.0]), np.zeros(2)),
}
Wrong = Callable[[Recording], Recording]
PLANE_Z_MM = -80.87


def recorded(arm: Arm, *, markers: bool, n: int = 80, seed: int = 0) -> Recording:
    """Return an arm that wanders, built some millimetres and degrees off its drawing, and measured with noise."""
    rng = np.random.default_rng(seed)
    q = 0.6 * np.sin(np.cumsum(rng.normal(0.0, 0.18, (n, arm.n_joints)), axis=0))
    built = Deviation(rng.normal(0.0, 3.0, arm.link_lengths_mm.shape), rng.normal(0.0, 0.05, arm.n_joints))
    rows = {
        "arm": arm,
        "sample": make_samples(n),
        "time_s": 0.5 * np.arange(n),
        "trajectory": np.full(n, "walk"),
        "q_cmd": q,
    }
    if not markers:
        return Recording(**rows, q_meas=q + built.joints_rad + rng.normal(0.0, 0.003, q.shape))
    flat = marker_positions(arm, q, built)
    points = np.concatenate([flat, np.zeros((*flat.shape[:2], 1))], axis=-1)
    pixels = project(nominal_camera(), robot_to_board(points, np.array([30.0, -20.0, PLANE_Z_MM])))
    pixels += rng.normal(0.0, 0.06, pixels.shape)
    seen = {name: pixels[:, k] for k, name in enumerate(arm.marker_names)}
    return Recording(**rows, camera=nominal_camera(), arm_plane_z_mm=PLANE_Z_MM, markers_px=seen)


def with_commands(change: Callable[[np.ndarray], None]) -> Wrong:
    def spoil(recording: Recording) -> Recording:
        q = recording.q_cmd.copy()
        change(q)
        return replace(recording, q_cmd=q)

    return spoil


def with_readings(change: Callable[[np.ndarray], None]) -> Wrong:
    def spoil(recording: Recording) -> Recording:
        assert recording.q_meas is not None
        q = recording.q_meas.copy()
        change(q)
        return replace(recording, q_meas=q)

    return spoil


def reverse(joint: int) -> Wrong:
    return with_commands(lambda q: np.negative(q[:, joint], out=q[:, joint]))


def found(recording: Recording) -> list[tuple[str, tuple[int, ...]]]:
    return [(error.error, error.joints) for error in screen(recording).errors]


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("markers", [False, True])
@pytest.mark.parametrize("arm", ARMS.values(), ids=ARMS)
def test_a_right_set_up_is_left_alone(arm: Arm, markers: bool, seed: int) -> None:
    right = recorded(arm, markers=markers, seed=seed)
    assert screen(right).errors == ()
    assert screen(right).recording is right


@pytest.mark.parametrize("markers", [False, True])
@pytest.mark.parametrize("arm", ARMS.values(), ids=ARMS)
def test_a_joint_that_turns_the_other_way_is_named_and_mended(arm: Arm, markers: bool) -> None:
    right = recorded(arm, markers=markers)
    for joint in range(arm.n_joints):
        screened = screen(reverse(joint)(right))
        assert [(e.error, e.joints) for e in screened.errors] == [("joint_reversed", (joint + 1,))]
        np.testing.assert_array_equal(screened.recording.q_cmd, right.q_cmd)
        assert f"joint {joint + 1} turns the other way" in screened.sentences[0]


@pytest.mark.parametrize("arm", [ARMS["planar3"], ARMS["four"]], ids=["planar3", "four"])
def test_two_joints_that_turn_the_other_way_are_both_named(arm: Arm) -> None:
    for one, other in combinations(range(arm.n_joints), 2):
        wrong = reverse(one)(reverse(other)(recorded(arm, markers=False)))
        assert sorted(found(wrong)) == [("joint_reversed", (one + 1,)), ("joint_reversed", (other + 1,))]


@pytest.mark.parametrize("markers", [False, True])
@pytest.mark.parametrize("arm", ARMS.values(), ids=ARMS)
def test_exchanged_joints_are_named(arm: Arm, markers: bool) -> None:
    def exchange(q: np.ndarray) -> None:
        q[:, [0, 1]] = q[:, [1, 0]]

    assert found(with_commands(exchange)(recorded(arm, markers=markers))) == [("joints_exchanged", (1, 2))]


@pytest.mark.parametrize("markers", [False, True])
def test_commands_counted_from_the_base_are_named(markers: bool) -> None:
    wrong = with_commands(lambda q: np.cumsum(q, axis=1, out=q))(recorded(ARMS["planar3"], markers=markers))
    assert found(wrong) == [("commanded_angles_absolute", ())]


def test_readings_counted_from_the_base_are_named() -> None:
    wrong = with_readings(lambda q: np.cumsum(q, axis=1, out=q))(recorded(ARMS["four"], markers=False))
    assert found(wrong) == [("measured_angles_absolute", ())]


@pytest.mark.parametrize("step", [np.pi, 2.0 * np.pi])
@pytest.mark.parametrize("rows", [slice(20, None), slice(55, 60), slice(3, 4)])
def test_turns_of_an_encoder_are_told_with_the_rows_and_taken_back(step: float, rows: slice) -> None:
    right = recorded(ARMS["planar3"], markers=False)

    def wrap(q: np.ndarray) -> None:
        q[rows, 1] -= step

    screened = screen(with_readings(wrap)(right))
    (error,) = screened.errors
    assert error.joints == (2,)
    assert f"from sample {rows.start}" in error.said
    np.testing.assert_allclose(screened.recording.q_meas, right.q_meas, atol=1e-12)


def test_an_encoder_that_wraps_at_an_angle_is_told_by_the_angle() -> None:
    right = recorded(ARMS["two"], markers=False)

    def wrap(q: np.ndarray) -> None:
        q[q[:, 0] > np.quantile(q[:, 0], 0.7), 0] -= 2.0 * np.pi

    (error,) = screen(with_readings(wrap)(right)).errors
    assert "wherever it is above" in error.said


def test_degrees_in_a_column_of_radians_are_told() -> None:
    wrong = with_readings(lambda q: np.multiply(q[:, 0], 180.0 / np.pi, out=q[:, 0]))(
        recorded(ARMS["two"], markers=False)
    )
    assert found(wrong) == [("degrees_for_radians", (1,))]


def test_a_zero_that_is_off_by_a_quarter_turn_is_told() -> None:
    def shift(q: np.ndarray) -> None:
        q[:, 1] -= np.pi / 2.0

    assert found(with_commands(shift)(recorded(ARMS["planar3"], markers=True))) == [("zero_off", (2,))]


@pytest.mark.parametrize("pair", list(combinations("abcf", 2)))
def test_markers_that_are_exchanged_throughout_are_named(pair: tuple[str, str]) -> None:
    right = recorded(ARMS["planar3"], markers=True)
    one, other = pair
    seen = {**right.markers_px, one: right.markers_px[other], other: right.markers_px[one]}
    (error,) = screen(replace(right, markers_px=seen)).errors
    assert error.said == f"markers {one.upper()} and {other.upper()} are exchanged in every row"


@pytest.mark.parametrize("arm", [ARMS["planar3"], ARMS["two"]], ids=["planar3", "two"])
def test_a_mirrored_picture_is_named(arm: Arm) -> None:
    right = recorded(arm, markers=True)
    seen = {name: [1279.0, 0.0] + pixels * [-1.0, 1.0] for name, pixels in right.markers_px.items()}
    assert found(replace(right, markers_px=seen)) == [("picture_mirrored", ())]


def test_lengths_in_the_wrong_order_are_put_right() -> None:
    right = recorded(ARMS["four"], markers=True)
    wrong = replace(right, arm=replace(right.arm, link_lengths_mm=right.arm.link_lengths_mm[::-1].copy()))
    screened = screen(wrong)
    assert [error.error for error in screened.errors] == ["link_lengths_out_of_order"]
    np.testing.assert_array_equal(screened.recording.arm.link_lengths_mm, right.arm.link_lengths_mm)


@pytest.mark.parametrize("markers", [False, True])
@pytest.mark.parametrize("arm", ARMS.values(), ids=ARMS)
def test_commands_that_are_all_in_degrees_are_told_in_one_sentence(arm: Arm, markers: bool) -> None:
    right = recorded(arm, markers=markers)
    wrong = with_commands(lambda q: np.multiply(q, 180.0 / np.pi, out=q))(right)
    assert found(wrong) == [("degrees_for_radians", tuple(range(1, arm.n_joints + 1)))]


@pytest.mark.parametrize(("axis", "size"), [(0, 1279.0), (1, 719.0)])
def test_a_mirror_is_named_before_joints_that_all_turn_the_other_way_from_other_zeros(axis: int, size: float) -> None:
    right = recorded(ARMS["planar3"], markers=True, seed=3)
    flip, shift = np.ones(2), np.zeros(2)
    flip[axis], shift[axis] = -1.0, size
    seen = {name: shift + pixels * flip for name, pixels in right.markers_px.items()}
    assert found(replace(right, markers_px=seen)) == [("picture_mirrored", ())]


@pytest.mark.parametrize("rows", [-2, 1])
@pytest.mark.parametrize("markers", [False, True])
@pytest.mark.parametrize("arm", ARMS.values(), ids=ARMS)
def test_pictures_out_of_step_are_left_to_the_diagnosis(arm: Arm, markers: bool, rows: int) -> None:
    right = recorded(arm, markers=markers, n=24)
    assert found(replace(right, q_cmd=np.roll(right.q_cmd, rows, axis=0))) == []
