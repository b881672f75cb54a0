"""A whole run of an arm with play: the geometry leaves it, the diagnosis names it, the extended twin takes it out."""

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from armtwin.models.recordings.reader import read_recording
from armtwin.models.twin import read_twin, rebuild
from armtwin.models.world import POSE_PERIOD_S

# One worker of pytest-xdist makes the run that all of these look at.
pytestmark = [pytest.mark.xdist_group("integration-extended-run"), pytest.mark.slow]

WIDTH_RAD = 0.0314
PLAY = f"""
schema = "armtwin.scenario/1"
title = "Play at joint 2"
seed = 6
board_views = 8
gauge_lengths_mm = [30.0]
gauge_placements = 2

[geometry]
length_errors_mm = [6.7, 4.6, -0.7, 1.0]
joint_errors_rad = [0.02, 0.018, 0.083]

[bench]
gravity_m_s2 = [0.0, -9.81]

[trajectories.circle_15]
kind = "circle"
radius_mm = 15
samples = 20

[trajectories.circle_25]
kind = "circle"
radius_mm = 25
samples = 20

[trajectories.line]
kind = "line"
start_mm = [-145, 25]
end_mm = [-115, 45]
samples = 8

[[effects]]
name = "backlash"
joint = 2
width_rad = {WIDTH_RAD}
"""


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("play")
    (folder / "play.toml").write_text(PLAY)
    command = [sys.executable, "-c", "from armtwin.scenarios.cli import main; main()"]
    done = subprocess.run(
        [*command, "run", str(folder / "play.toml"), "--out", str(folder / "out")],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return folder / "out"


@pytest.fixture(scope="module")
def results(run: Path) -> dict[str, Any]:
    found: dict[str, Any] = json.loads((run / "results.json").read_text())
    return found


@pytest.fixture(scope="module")
def rows(results: dict[str, Any]) -> dict[str, dict[str, Any]]:
    return {row["run"]: row for row in results["gain"]["rows"]}


def test_the_play_is_named_at_its_joint_with_its_width_beside_the_truth(results: dict[str, Any]) -> None:
    (found,) = [row for row in results["diagnosis"]["beside_truth"] if row["effect"] == "backlash"]
    assert (found["joint"], found["origin"]) == (2, "injected")
    width = next(parameter for parameter in found["parameters"] if parameter["name"] == "width_rad")
    assert width["truth"] == WIDTH_RAD
    assert abs(width["value"] / WIDTH_RAD - 1.0) < 0.05
    assert width["std"] > 0


def test_the_extended_twin_leaves_a_quarter_of_a_millimetre_at_most_where_the_geometry_leaves_more(
    rows: dict[str, dict[str, Any]],
) -> None:
    assert rows["after"]["mean_mm"] > 0.5
    assert rows["extended"]["mean_mm"] < 0.25
    assert rows["extended"]["true_mean_mm"] < 0.25
    assert rows["extended"]["reduction_percent"] > 93.0


def test_each_error_has_its_interval(rows: dict[str, dict[str, Any]]) -> None:
    for row in rows.values():
        low, high = row["mean_ci95_mm"]
        assert low <= row["mean_mm"] <= high


def test_the_line_by_the_extended_twin_comes_after_all_that_was_diagnosed(run: Path) -> None:
    """Play remembers: the bench does again what it had done, unseen, before the first picture is taken."""
    before, extended = (read_recording(run / "recordings" / name) for name in ("before", "extended"))
    assert extended.time_s[0] == pytest.approx((len(before) + 1) * POSE_PERIOD_S)
    assert set(extended.trajectory) == {"line"}
    assert len(list((run / "recordings" / "extended" / "frames").iterdir())) == len(extended) == 8


def test_the_commands_of_the_extended_twin_differ_from_the_geometrys_by_the_play(run: Path) -> None:
    after, extended = (read_recording(run / "recordings" / name) for name in ("after", "extended"))
    apart = np.abs(extended.q_cmd - after.q_cmd).mean(axis=0)
    assert 0.25 * WIDTH_RAD < apart[1] < WIDTH_RAD


def test_the_twin_file_rebuilds_a_bench_with_the_play_in_it(run: Path) -> None:
    twin = read_twin(run / "diagnosis" / "twin.toml")
    assert ("backlash", 2) in [(effect.effect, effect.joint) for effect in twin.effects]
    assert rebuild(twin).compile().nq > 3  # a joint for the gap beside the servos'


def test_the_report_tells_the_story_in_order(run: Path) -> None:
    page = (run / "report.html").read_text("utf-8")
    slugs = ["calibration", "validation", "remainder", "causes", "gain", "paper"]
    places = [page.index(f'<section id="{slug}">') for slug in slugs]
    assert places == sorted(places)
    assert "backlash, joint 2" in page[places[3] : places[4]]
