"""What a recording cannot tell is said in one line each."""

from dataclasses import replace

import numpy as np
import pytest

from armtwin.models.arm import Arm
from armtwin.models.errors import RecordingError
from armtwin.models.recordings.recording import Recording, make_samples
from armtwin.scenarios.diagnosis.checks import check_recording, notes_on

N = 40


def recording(q_cmd: np.ndarray, time_s: np.ndarray | None = None) -> Recording:
    return Recording(
        arm=Arm("two", np.array([100.0, 50.0]), np.zeros(2)),
        sample=make_samples(len(q_cmd)),
        time_s=np.full(len(q_cmd), np.nan) if time_s is None else time_s,
        trajectory=np.full(len(q_cmd), "path"),
        q_cmd=q_cmd,
        q_meas=q_cmd,
    )


def wandering() -> Recording:
    return recording(np.random.default_rng(0).uniform(-1.0, 1.0, (N, 2)))


def test_of_a_rich_recording_there_is_nothing_to_say() -> None:
    assert notes_on(wandering()) == []


def test_a_joint_that_never_moves_is_named() -> None:
    rich = wandering()
    q = rich.q_cmd.copy()
    q[:, 1] = 0.3
    (note,) = notes_on(replace(rich, q_cmd=q))
    assert note == "theta2_cmd_rad never changes: nothing can be told of joint 2"


def test_joints_that_only_turn_one_way_are_named() -> None:
    rich = wandering()
    q = rich.q_cmd.copy()
    q[:, 0] = np.sort(q[:, 0])
    (note,) = notes_on(replace(rich, q_cmd=q))
    assert note.startswith("joint 1: every pose is approached from the same side")


def test_a_clock_that_stands_still_is_refused() -> None:
    with pytest.raises(RecordingError, match="time_s is 12 in every row, a clock that stands still; leave the column"):
        check_recording(replace(wandering(), time_s=np.full(N, 12.0)))


def test_where_no_joint_turns_back_it_is_said_what_cannot_be_told() -> None:
    rich = wandering()
    q = np.sort(rich.q_cmd, axis=0)
    q[:, 1] *= -1.0
    check_recording(replace(rich, q_cmd=q))
    (note,) = notes_on(replace(rich, q_cmd=q))
    assert "no joint ever turns back (theta1_cmd_rad only grows, theta2_cmd_rad only falls)" in note
    assert "backlash and hysteresis are one with a joint's zero" in note
    assert "add the same poses in reverse order" in note


def test_the_same_poses_there_and_back_are_enough() -> None:
    there = np.sort(wandering().q_cmd, axis=0)
    check_recording(recording(np.concatenate([there, there[::-1]])))


def test_a_joint_that_rests_turns_neither_way() -> None:
    q = np.sort(wandering().q_cmd, axis=0)
    q[:, 1] = 0.3
    assert any("no joint ever turns back (theta1_cmd_rad only grows)" in note for note in notes_on(recording(q)))


def test_commands_read_in_whole_degrees_are_said_to_be_with_the_error_that_makes() -> None:
    rich = wandering()
    q = rich.q_cmd.copy()
    q[:, 0] = np.radians(np.round(np.degrees(q[:, 0])))
    (note,) = notes_on(replace(rich, q_cmd=q))
    assert "joint 1" in note
    assert "steps of 1 deg (0.01745 rad)" in note
    assert "0.005 rad (0.76 mm at the tip)" in note


def test_a_log_of_a_moving_arm_is_not_taken_for_poses() -> None:
    time_s = np.arange(0.0, 4.0, 0.02)
    q = np.stack([np.sin(time_s), 0.5 * np.cos(time_s)], axis=-1)
    with pytest.raises(RecordingError, match=r"rows are 0\.02 s apart while the arm moves, a log of motion"):
        check_recording(recording(q, time_s))
    check_recording(recording(q, 100.0 * time_s))  # the same commands at two seconds each are poses
