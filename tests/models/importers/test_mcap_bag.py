"""ROS 2 bags, written by the library that reads them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from armtwin.models.errors import InputError
from armtwin.models.importers.mcap_bag import read_mcap

writer = pytest.importorskip("mcap_ros2.writer")

STAMP = "std_msgs/Header header\n"
HEADER = (
    "\n================================================================================\n"
    "MSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n"
    "================================================================================\n"
    "MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n"
)
JOINT_STATE = STAMP + "string[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort" + HEADER
NUMBERS = "float64[] data"
POINT = "float64[] positions"
CONTROLLER = (
    STAMP
    + "string[] joint_names\ntrajectory_msgs/JointTrajectoryPoint reference\n"
    + "trajectory_msgs/JointTrajectoryPoint feedback\n"
    + HEADER.rstrip("\n")
    + "\n================================================================================\n"
    + "MSG: trajectory_msgs/JointTrajectoryPoint\nfloat64[] positions\n"
)
START = 1_700_000_000
N = 20


def header(time_s: float) -> dict[str, Any]:
    return {"stamp": {"sec": START + int(time_s), "nanosec": int(1e9 * (time_s % 1))}, "frame_id": ""}


def log_ns(time_s: float) -> int:
    """The recorder hears of a message 50 ms after it was stamped."""
    return int(1e9 * (START + time_s + 0.05))


def write_states(path: Path, *, commands: str | None = "/commands", extra: str | None = None) -> Path:
    with path.open("wb") as stream:
        bag = writer.Writer(stream)
        state = bag.register_msgdef("sensor_msgs/msg/JointState", JOINT_STATE)
        numbers = bag.register_msgdef("std_msgs/msg/Float64MultiArray", NUMBERS)
        for k in range(N):
            time = 0.1 * k
            names = ["shoulder", "elbow"] if k % 2 else ["elbow", "shoulder"]  # drivers do not keep an order
            positions = [0.01 * k, -0.02 * k] if k % 2 else [-0.02 * k, 0.01 * k]
            message = {"header": header(time), "name": names, "position": positions, "velocity": [], "effort": []}
            for topic in ("/joint_states", *([extra] if extra else [])):
                bag.write_message(topic, state, message, log_ns(time))
            if commands and k >= 2:
                bag.write_message(commands, numbers, {"data": [-0.03 * k, 0.02 * k]}, log_ns(time + 0.03))
        bag.finish()
    return path


def test_states_and_commands_are_joined_by_name_and_by_time(tmp_path: Path) -> None:
    log = read_mcap(write_states(tmp_path / "bag.mcap"))
    assert log.joints == ("elbow", "shoulder")
    first = 3  # the first command came after row 2; numbers carry no stamp: the log's time, 50 ms on, holds
    np.testing.assert_allclose(log.q_meas[:, 1], 0.01 * np.arange(first, N), atol=1e-9)
    np.testing.assert_allclose(log.time_s, 0.1 * np.arange(first, N), atol=1e-6)
    np.testing.assert_allclose(log.q_cmd[:, 0], -0.03 * np.arange(first - 1, N - 1), atol=1e-9)
    assert log.commanded_s is not None
    np.testing.assert_allclose(log.time_s - log.commanded_s, 0.02, atol=1e-6)
    assert "commanded: /commands (std_msgs/msg/Float64MultiArray)" in log.notes


def test_the_folder_of_a_bag_stands_for_the_file_in_it(tmp_path: Path) -> None:
    write_states(tmp_path / "run_0.mcap")
    assert len(read_mcap(tmp_path)) == N - 3
    write_states(tmp_path / "run_1.mcap")
    with pytest.raises(InputError, match=r"2 \.mcap files in the folder"):
        read_mcap(tmp_path)


def test_a_controllers_state_holds_both(tmp_path: Path) -> None:
    path = tmp_path / "bag.mcap"
    with path.open("wb") as stream:
        bag = writer.Writer(stream)
        kind = bag.register_msgdef("control_msgs/msg/JointTrajectoryControllerState", CONTROLLER)
        for k in range(N):
            message = {
                "header": header(0.1 * k),
                "joint_names": ["shoulder"],
                "reference": {"positions": [0.02 * k]},
                "feedback": {"positions": [0.01 * k]},
            }
            bag.write_message("/arm_controller/controller_state", kind, message, log_ns(0.1 * k))
        bag.finish()
    log = read_mcap(path)
    np.testing.assert_allclose(log.q_cmd[:, 0], 0.02 * np.arange(N))
    np.testing.assert_allclose(log.q_meas[:, 0], 0.01 * np.arange(N))


def test_a_bag_without_commands_says_what_it_holds(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"name one with --command-topic. Its topics: /joint_states \(sensor_msgs"):
        read_mcap(write_states(tmp_path / "bag.mcap", commands=None))


def test_topics_that_could_both_be_meant_are_named_and_one_can_be_chosen(tmp_path: Path) -> None:
    path = write_states(tmp_path / "bag.mcap", extra="/other/states")
    with pytest.raises(InputError, match="2 topics can be meant; name one with --command-topic"):
        read_mcap(path)
    assert len(read_mcap(path, command="/commands")) == N - 3
    with pytest.raises(InputError, match="did you mean '/commands'"):
        read_mcap(path, command="/command")


@pytest.mark.parametrize("cut", [10, 400])
def test_a_file_that_is_no_bag_is_one_line(tmp_path: Path, cut: int) -> None:
    path = write_states(tmp_path / "bag.mcap")
    path.write_bytes(path.read_bytes()[:cut])
    with pytest.raises(InputError, match=r"bag\.mcap: "):
        read_mcap(path)
