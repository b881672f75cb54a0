"""`armtwin export`: files that other tools load, and what they lack said on the screen."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest

from armtwin.models.arm import nominal_arm
from armtwin.models.kinematics import Deviation
from armtwin.models.twin import Twin, TwinEffect, write_twin
from armtwin.scenarios.cli import main


@pytest.fixture
def twin(tmp_path: Path) -> Path:
    effects = (TwinEffect("backlash", 2, None, {"width_rad": 0.02}),)
    deviation = Deviation(np.array([1.0, 0.0, 0.0, 0.0]), np.zeros(3))
    write_twin(tmp_path / "twin.toml", Twin(nominal_arm(), deviation, np.zeros(3), None, effects))
    return tmp_path / "twin.toml"


def leave(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> tuple[object, str, str]:
    with pytest.raises(SystemExit) as left:
        main(["export", *arguments])
    out, err = capsys.readouterr()
    return left.value.code, out, err


def test_both_files_load_and_what_urdf_lacks_is_said(twin: Path, capsys: pytest.CaptureFixture[str]) -> None:
    xml, urdf = twin.with_name("arm.xml"), twin.with_name("robot.urdf")
    code, out, _ = leave([str(twin), "--mjcf", str(xml), "--urdf", str(urdf)], capsys)
    assert code == 0
    assert f"{xml}: the calibrated arm, backlash (joint 2)" in out
    assert "without backlash (joint 2), which needs a spring, a gap" in out
    assert mujoco.MjModel.from_xml_path(str(xml)).njnt == 4  # three joints and the gap
    assert mujoco.MjModel.from_xml_path(str(urdf)).njnt == 3


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ([], "give --mjcf OUT.xml or --urdf OUT.urdf"),
        (["--mjcf", "arm.xml", "--onto", "own.urdf"], "give --urdf OUT.urdf too"),
        (["--urdf", "a.urdf", "--tip", "hand"], "give --onto ROBOT.urdf"),
        (["--mjcf", "a.xml", "--urdf", "a.urdf"], "give the files different names"),
        (["--urdf", "a.urdf", "--onto", "none.urdf"], "none.urdf: no such file"),
    ],
)
def test_what_does_not_go_together_is_refused(
    twin: Path, arguments: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    code, _, err = leave([str(twin), *arguments], capsys)
    assert code == 2
    assert said in err
