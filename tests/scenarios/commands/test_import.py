"""`armtwin import`: a log becomes a recording folder, and what was taken for what is said."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest

from armtwin.models.recordings.moving_reader import read_moving
from armtwin.models.recordings.reader import read_recording
from armtwin.scenarios.cli import main
from tests.models.importers.test_sage import write_motion


def leave(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> tuple[object, str, str]:
    with pytest.raises(SystemExit) as left:
        main(["import", *arguments])
    return left.value.code, *capsys.readouterr()


@pytest.fixture
def poses(tmp_path: Path) -> Path:
    path = tmp_path / "poses.csv"
    path.write_text("seconds;elbow_target_deg;elbow_actual_deg\n0;10;9,5\n2;20;19\n4;30;29\n")
    return path


def test_a_proposed_mapping_is_shown_and_saved_and_used_once_it_is_agreed_to(
    tmp_path: Path, poses: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "rec"
    code, shown, err = leave(["csv", str(poses), "--out", str(out)], capsys)
    assert code == 2
    assert "elbow_target_deg [deg]" in shown
    assert "not used yet; give --yes, or mend it and give --mapping" in err
    assert not out.exists()
    mapping = tmp_path / "rec.mapping.toml"
    code, said, _ = leave(["csv", str(poses), "--out", str(out), "--mapping", str(mapping)], capsys)
    assert code == 0
    assert "every link is called 100 mm" in said
    read = read_recording(out)
    np.testing.assert_allclose(np.degrees(read.q_cmd[:, 0]), [10, 20, 30])
    assert read.q_meas is not None
    np.testing.assert_allclose(np.degrees(read.q_meas[:, 0]), [9.5, 19, 29])


def test_a_moving_log_is_written_as_the_contract_has_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_motion(tmp_path / "wave")
    code, said, err = leave(["sage", str(tmp_path / "wave"), "--out", str(tmp_path / "rec")], capsys)
    assert code == 0, err
    assert "9 samples of a moving arm, 2 joints, 1 trajectories" in said
    header = json.loads((tmp_path / "rec" / "recording.json").read_text())
    assert (header["schema"], header["motion"]) == ("armtwin.recording/1", "moving")
    with (tmp_path / "rec" / "samples.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    assert [float(row["theta1_cmd_rad"]) for row in rows] == pytest.approx([0.1 * k for k in range(9)])
    assert float(rows[0]["theta2_vel_rad_s"]) == -4.5
    assert float(rows[0]["time_s"]) - float(rows[0]["commanded_s"]) == pytest.approx(0.019, abs=1e-5)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["csv", "none.csv"], "none.csv: no such file"),
        (["lerobot", "none"], "has no info.json"),
        (["sage", "none"], "control.csv: no such file"),
        (["mcap", "none.mcap"], "none.mcap: no such file"),
        (["lerobot", "none", "--episodes", "a"], "whole numbers with commas between"),
    ],
)
def test_a_source_that_is_not_there_is_told_with_what_is_wanted(
    tmp_path: Path, arguments: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    code, _, err = leave([*arguments, "--out", str(tmp_path / "rec")], capsys)
    assert (code, said in err) == (2, True), err


def test_an_arm_with_other_joints_is_refused(tmp_path: Path, poses: Path, capsys: pytest.CaptureFixture[str]) -> None:
    arm = tmp_path / "arm.toml"
    arm.write_text('schema = "armtwin.arm/1"\nname = "two"\nlink_lengths_mm = [100.0, 80.0]\n')
    code, _, err = leave(["csv", str(poses), "--out", str(tmp_path / "rec"), "--yes", "--arm", str(arm)], capsys)
    assert code == 2
    assert "arm.toml: has 2 joints, the log 1 (elbow)" in err


MODEL = """<mujoco><worldbody><body name="upper"><joint name="shoulder" axis="0 1 0"/>
<inertial pos="0.1 0 0" mass="0.2" diaginertia="1e-4 2e-4 2e-4"/><geom type="mesh" mesh="skin"/>
<body name="fore"><joint name="elbow" axis="0 1 0"/><inertial pos="0.1 0 0" mass="0.1" diaginertia="1e-4 2e-4 2e-4"/>
</body></body></worldbody><asset><mesh name="skin" file="skin.stl"/></asset></mujoco>"""


@pytest.mark.parametrize(
    ("names", "said"),
    [
        ("shoulder\nelbow", "its joints are shoulder, elbow"),
        ("a\nb", "its joints are shoulder (a), elbow (b)"),  # as many as the model's hinges: in their order
    ],
)
def test_the_joints_of_a_log_are_those_of_the_model_that_is_given(
    tmp_path: Path, names: str, said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    write_motion(tmp_path / "wave", names=names)
    (tmp_path / "arm.xml").write_text(MODEL)
    arguments = ["sage", str(tmp_path / "wave"), "--out", str(tmp_path / "rec"), "--arm", str(tmp_path / "arm.xml")]
    code, shown, err = leave(arguments, capsys)
    assert (code, said in shown) == (0, True), err
    assert read_moving(tmp_path / "rec").joint_names == ("shoulder", "elbow")


def test_a_model_that_has_other_joints_is_refused_with_its_own(
    tmp_path: Path, poses: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    poses.write_text("time_s,wrist_target_deg,wrist_actual_deg\n0,10,9.5\n0.02,20,19\n0.04,30,29\n")
    (tmp_path / "arm.xml").write_text(MODEL)
    arguments = ["csv", str(poses), "--out", str(tmp_path / "rec"), "--yes", "--arm", str(tmp_path / "arm.xml")]
    code, _, err = leave(arguments, capsys)
    assert code == 2
    assert "arm.xml: has no joint 'wrist', which the log has; its 2 are shoulder, elbow: choose" in err
    assert not (tmp_path / "rec").exists()


def test_a_folder_of_tables_is_one_recording_of_as_many_motions(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "logs").mkdir()
    rows = "\n".join(f"{20 * k},{10.5 + k},{10.25 + k}" for k in range(8))
    for name in ("steps", "chirp"):
        (tmp_path / "logs" / f"{name}.csv").write_text(f"t_ms,elbow_target,elbow_actual\n{rows}\n")
    code, shown, err = leave(["csv", str(tmp_path / "logs"), "--out", str(tmp_path / "rec"), "--yes"], capsys)
    assert code == 0, err
    assert "by their values, not their names, told the units of: elbow_target, elbow_actual" in shown
    assert "next: armtwin diagnose" in shown
    assert read_moving(tmp_path / "rec").motions == ("chirp", "steps")
