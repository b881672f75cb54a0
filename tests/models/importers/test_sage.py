"""SAGE logs: lists in cells, times in µs or s."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from armtwin.models.errors import InputError
from armtwin.models.importers.sage import read_sage


def write_motion(folder: Path, unit: float = 1e6, names: str | None = "shoulder\nelbow\n") -> Path:
    folder.mkdir()
    control = ["type,timestamp,positions"]
    state = ["type,timestamp,positions,velocities,torques"]
    for k in range(10):
        control.append(f'CONTROL,{unit * (1000 + 0.02 * k + 0.001):.6f},"[{0.1 * k}, {-0.1 * k}]"')
        cells = f'"[{0.09 * k}, {-0.09 * k}]","[4.5, -4.5]","[0.3, 0.3]"'
        state.append(f"STATE_MOTOR,{unit * (1000 + 0.02 * k):.6f},{cells}")
    (folder / "control.csv").write_text("\n".join(control) + "\n")
    (folder / "state_motor.csv").write_text("\n".join(state) + "\n")
    if names:
        (folder / "joint_list.txt").write_text(names)
    return folder


def test_each_motion_in_a_folder_of_motions_is_a_trajectory(tmp_path: Path) -> None:
    for name in ("wave", "steps"):
        write_motion(tmp_path / name)
    log = read_sage(tmp_path)
    assert list(dict.fromkeys(log.trajectory.tolist())) == ["steps", "wave"]
    assert (np.diff(log.time_s) > 0).all()
    assert "each trajectory's clock begins anew: they are laid 5 s apart" in log.notes


@pytest.mark.parametrize(("unit", "said"), [(1e6, "times are in µs"), (1.0, "times are in s")])
def test_commands_are_held_to_the_rows_after_them(tmp_path: Path, unit: float, said: str) -> None:
    log = read_sage(write_motion(tmp_path / "wave", unit))
    assert log.joints == ("shoulder", "elbow")
    np.testing.assert_allclose(log.q_meas[:, 0], 0.09 * np.arange(1, 10))
    np.testing.assert_allclose(log.q_cmd[:, 0], 0.1 * np.arange(9))  # row 1 still stands under the first command
    assert log.commanded_s is not None
    np.testing.assert_allclose(log.time_s - log.commanded_s, 0.019, atol=1e-5)
    np.testing.assert_allclose(log.extras["vel_rad_s"][:, 1], -4.5)
    assert said in log.notes
    assert "torque_nm" not in log.extras


def test_a_gripper_is_left_out(tmp_path: Path) -> None:
    log = read_sage(write_motion(tmp_path / "wave", names="shoulder\ngripper\n"))
    assert log.joints == ("shoulder",)
    assert "left out: gripper" in log.notes


@pytest.mark.parametrize(
    ("file", "old", "new", "said"),
    [
        ("control.csv", "positions", "place", "column 'positions' is missing"),
        ("state_motor.csv", "[0.09, -0.09]", "[0.09]", "2 numbers is wanted"),
        ("state_motor.csv", "[0.09, -0.09]", "[__import__('os'), 1]", "2 numbers is wanted"),
        ("joint_list.txt", "elbow\n", "", "1 joints are named, its rows hold 2"),
    ],
)
def test_a_broken_log_is_named_by_its_line(tmp_path: Path, file: str, old: str, new: str, said: str) -> None:
    folder = write_motion(tmp_path / "wave")
    (folder / file).write_text((folder / file).read_text().replace(old, new))
    with pytest.raises(InputError, match=said):
        read_sage(folder)
