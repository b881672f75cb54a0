"""`armtwin diagnose` of a moving arm's log: the contract's data, a report, a twin; or one line that says why not."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path

import pytest

from armtwin.scenarios.cli import main
from armtwin.scenarios.motion.pipeline import report_motion
from armtwin.scenarios.motion.resimulate import resimulated
from tests.support.browser import CHROMIUM, DESK_PX, PHONE_PX, chromium, faults_of
from tests.support.moving import Faults, write_log

LAG_S = 0.08


def exit_code(arguments: list[str]) -> object:
    with pytest.raises(SystemExit) as left:
        main(arguments)
    return left.value.code


@pytest.fixture(scope="module")
def diagnosed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a diagnosis of a log in which joint 2 follows slowly."""
    folder = tmp_path_factory.mktemp("moving")
    log = write_log(folder / "log", 21, Faults({1: {"tau": LAG_S}}))
    assert exit_code(["diagnose", str(log), "--out", str(folder / "out")]) == 0
    return folder / "out"


def test_the_data_is_the_contracts(diagnosed: Path) -> None:
    data = json.loads((diagnosed / "diagnosis.json").read_text("utf-8"))
    assert data["schema"] == "armtwin.diagnosis/1"
    assert data["verdict"] == "named"
    (cause,) = data["causes"]
    assert (cause["effect"], cause["joint"], cause["marker"]) == ("servo_lag", 2, None)
    value = cause["parameters"]["time_constant_s"]
    assert abs(value["value"] - LAG_S) < 5.0 * value["std"] + 5e-4
    for entry in data["held_out"]["joints"]:
        keys = ("command", "nominal", "before", "after")
        assert set(entry) == {
            "trajectory",
            "joint",
            "after_worst_rad",
            "noise_floor_rad",
            *(f"{k}_rms_rad" for k in keys),
        }
    slow = [entry for entry in data["held_out"]["joints"] if entry["joint"] == 2]
    assert all(entry["after_rms_rad"] < 0.1 * entry["before_rms_rad"] for entry in slow)
    assert data["held_out"]["after_rms_mm"] < 0.2 * data["held_out"]["before_rms_mm"]


def test_the_twin_says_which_effects_it_holds(diagnosed: Path) -> None:
    twin = tomllib.loads((diagnosed / "twin.toml").read_text("utf-8"))
    assert [(one["effect"], one["joint"]) for one in twin["effects"]] == [("servo_lag", 2)]


@pytest.mark.skipif(CHROMIUM is None, reason="no Chromium on this machine")
@pytest.mark.xdist_group("browser")
def test_its_report_is_whole_at_a_desk_and_on_a_phone(diagnosed: Path) -> None:
    with chromium() as browser:
        assert faults_of(browser, diagnosed / "report.html", DESK_PX) == []
        assert faults_of(browser, diagnosed / "report.html", PHONE_PX) == []


def test_a_log_that_is_wrong_is_one_line_and_leaves_nothing(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    log = write_log(tmp_path / "log", 1, Faults())
    lines = (log / "samples.csv").read_text("utf-8").splitlines()
    lines[7] = lines[6]
    (log / "samples.csv").write_text("\n".join(lines), "utf-8")
    assert exit_code(["diagnose", str(log), "--out", str(tmp_path / "out")]) == 2
    said = capsys.readouterr().err.strip()
    assert "samples.csv: line 8" in said
    assert "\n" not in said
    assert not (tmp_path / "out").exists()


def test_the_twin_that_mujoco_moves_is_within_a_milliradian_of_the_held_out_motions(tmp_path: Path) -> None:
    log = write_log(tmp_path / "log", 23, Faults({0: {"delay": 0.05}, 2: {"play": 0.03}}))
    found = report_motion(log)
    again = resimulated(found)
    assert again is not None
    assert not again.left_out
    assert max(one.before_rms_rad for one in found.held_out) > 5e-3
    assert again.rms_rad.max() < 1e-3
