"""`armtwin correct` and `armtwin simulate` from file to file."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
import tomli_w

from armtwin.models.arm import nominal_arm
from armtwin.models.camera_files import nominal_camera, write_camera
from armtwin.models.kinematics import Deviation
from armtwin.models.plan import read_plan
from armtwin.models.recordings.reader import read_recording
from armtwin.models.twin import Twin, TwinEffect, write_twin
from armtwin.scenarios.cli import main

DEVIATION = Deviation(np.array([1.5, -2.0, 0.4, 0.0]), np.array([0.02, -0.03, 0.01]))

BENCH = {
    "schema": "armtwin.bench/1",
    "serial": {"port": "/dev/ttyACM0"},
    "camera": {"source": "/dev/video0", "calibration": "camera.yaml", "arm_plane_z_mm": -80.87},
    "joints": [
        {"servo": 2, "zero_us": 1500.0, "us_per_rad": 636.62, "direction": -1, "min_rad": -1.2, "max_rad": 1.2},
        {"servo": 1, "zero_us": 1450.0, "us_per_rad": 600.0, "direction": 1, "min_rad": -1.2, "max_rad": 1.2},
        {"servo": 3, "zero_us": 1500.0, "us_per_rad": 600.0, "direction": 1, "min_rad": -1.4, "max_rad": 1.2},
    ],
}


@pytest.fixture
def twin(tmp_path: Path) -> Path:
    effects = (TwinEffect("backlash", 2, None, {"width_rad": 0.02}),)
    write_twin(tmp_path / "twin.toml", Twin(nominal_arm(), DEVIATION, np.zeros(3), nominal_camera(), effects))
    return tmp_path / "twin.toml"


def leave(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> tuple[object, str, str]:
    with pytest.raises(SystemExit) as left:
        main(arguments)
    return left.value.code, *capsys.readouterr()


def test_a_path_of_points_is_corrected_and_what_is_out_of_reach_is_said(
    twin: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    plan, out = twin.with_name("path.csv"), twin.with_name("corrected.csv")
    plan.write_text("x_mm;y_mm\n-150,5;40\n-900;0\n-140;45,25\n")
    code, said, _ = leave(["correct", str(twin), str(plan), "--out", str(out)], capsys)
    assert code == 0
    assert "out of reach, left out: line 3, 619.8 mm away" in said
    corrected = read_plan(out, 3)
    assert list(corrected.trajectory) == ["path", "path"]


def test_pulses_are_whole_microseconds_by_the_benchs_servos(twin: Path, capsys: pytest.CaptureFixture[str]) -> None:
    plan, out, bench = (twin.with_name(name) for name in ("path.csv", "corrected.csv", "bench.toml"))
    plan.write_text("theta1_cmd_deg,theta2_cmd_deg,theta3_cmd_deg\n10,-5,5\n12,-7,4\n")
    write_camera(twin.with_name("camera.yaml"), nominal_camera())
    bench.write_text(tomli_w.dumps(BENCH))
    code, said, err = leave(["correct", str(twin), str(plan), "--out", str(out), "--pulses", str(bench)], capsys)
    assert code == 0, err
    assert "corrected_pulses.csv" in said
    q = read_plan(out, 3).q_cmd
    with twin.with_name("corrected_pulses.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    # Joint 1 is on servo 2 and turns against it, joint 2 on servo 1.
    assert [int(row["servo2_us"]) for row in rows] == [round(1500 - 636.62 * angle) for angle in q[:, 0]]
    assert [int(row["servo1_us"]) for row in rows] == [round(1450 + 600.0 * angle) for angle in q[:, 1]]


def test_a_command_beyond_the_benchs_limits_writes_nothing(twin: Path, capsys: pytest.CaptureFixture[str]) -> None:
    plan, out, bench = (twin.with_name(name) for name in ("path.csv", "corrected.csv", "bench.toml"))
    plan.write_text("theta1_cmd_deg,theta2_cmd_deg,theta3_cmd_deg\n80,0,0\n")
    write_camera(twin.with_name("camera.yaml"), nominal_camera())
    bench.write_text(tomli_w.dumps(BENCH))
    code, _, err = leave(["correct", str(twin), str(plan), "--out", str(out), "--pulses", str(bench)], capsys)
    assert code == 2
    assert "joint 1 at" in err
    assert "outside its limits" in err
    assert not out.exists()


def test_a_simulated_recording_stands_in_its_folder_and_is_not_written_over(
    twin: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = twin.with_name("made")
    code, said, _ = leave(["simulate", str(twin), "paper", "--out", str(out), "--hold-out", "line"], capsys)
    assert (code, said.split(";")[0]) == (0, f"150 poses in {out}")
    assert read_recording(out).held_out == ("line",)
    code, _, err = leave(["simulate", str(twin), "paper", "--out", str(out)], capsys)
    assert (code, "is not empty" in err) == (2, True)
