"""A moving twin of a model's arm from the command line: simulated, diagnosed, exported, with its model beside it."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from armtwin.models.moving_twin import read_moving_twin
from armtwin.scenarios.cli import main
from tests.models.test_moving_twin import TWIN, written


def leave(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> tuple[object, str, str]:
    with pytest.raises(SystemExit) as left:
        main(arguments)
    return left.value.code, *capsys.readouterr()


def plan(path: Path) -> Path:
    t = np.arange(0.0, 8.0, 0.02)
    swing = 0.5 * np.sin(2 * np.pi * (0.3 + 0.1 * t) * t)
    rows = [
        f"{name},{s:.6f},{-0.7 * s:.6f}" for name, shape in (("a", swing), ("b", -swing), ("c", swing)) for s in shape
    ]
    path.write_text("\n".join(["trajectory,theta1_cmd_rad,theta2_cmd_rad", *rows]) + "\n")
    return path


def test_what_it_is_sent_through_is_logged_diagnosed_and_exported(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    twin, commands = written(tmp_path, TWIN), plan(tmp_path / "plan.csv")
    log, out = tmp_path / "log", tmp_path / "found"
    code, said, err = leave(["simulate", str(twin), str(commands), "--out", str(log), "--hold-out", "b"], capsys)
    assert (code, "1200 rows of the moving arm" in said) == (0, True), err
    code, said, err = leave(["diagnose", str(log), "--out", str(out)], capsys)
    assert (code, bool(re.search(r"friction, joint 2 \(pitch\)", said))) == (0, True), said + err
    assert (out / "two.xml").is_file()
    ((name, site, values),) = read_moving_twin(out / "twin.toml").causes
    assert (name, site.joint) == ("friction", 2)
    assert values["coulomb_rad"] == pytest.approx(0.012, rel=0.1)
    code, _, err = leave(["export", str(out / "twin.toml"), "--mjcf", str(tmp_path / "arm.xml")], capsys)
    assert code == 0, err


@pytest.mark.parametrize(
    ("more", "said"),
    [
        (["--frames"], "pictures are taken of poses at rest"),
        (["--hold-out", "z"], "has no trajectory 'z'; it has a, b, c"),
        (["--model", "none.xml"], "none.xml: no such file"),
    ],
)
def test_what_a_moving_twin_cannot_is_told_in_a_line(
    tmp_path: Path, more: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    twin, commands = written(tmp_path, TWIN), plan(tmp_path / "plan.csv")
    code, _, err = leave(["simulate", str(twin), str(commands), "--out", str(tmp_path / "log"), *more], capsys)
    assert (code, said in err) == (2, True), err
    assert not (tmp_path / "log").exists()


def test_a_motion_that_begins_twice_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    twin, commands = written(tmp_path, TWIN), plan(tmp_path / "plan.csv")
    commands.write_text(commands.read_text().replace("\nc,", "\na,"))
    code, _, err = leave(["simulate", str(twin), str(commands), "--out", str(tmp_path / "log")], capsys)
    assert (code, "trajectory 'a' begins twice" in err) == (2, True), err
