"""`armtwin import`: a log becomes a recording folder, and what was taken for what is said."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest

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
