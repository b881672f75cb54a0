"""Bad input is refused before the port is opened: the bench files here name a port that does not exist."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from armtwin.hardware.bench.bench_file import BenchSetup, read_bench
from armtwin.hardware.capture.folder import CaptureFolder
from armtwin.models.arm import nominal_arm
from armtwin.models.errors import InputError, RecordingError, UnreachablePoseError
from armtwin.models.plan import Plan, write_plan
from armtwin.scenarios.commands.capture import capture_command
from armtwin.scenarios.plans import load_plan
from tests.support.bench import bench_table, setup, write_bench

__all__ = ["bench_table", "setup", "write_bench"]


@pytest.fixture
def bench(bench_table: dict[str, Any], write_bench: Callable[[dict[str, Any]], Path], tmp_path: Path) -> Path:
    bench_table["serial"]["port"] = str(tmp_path / "no-port")
    return write_bench(bench_table)


def plan_file(folder: Path, q: list[list[float]], payload_kg: list[float] | None = None) -> str:
    path = folder / "plan.csv"
    write_plan(path, Plan(np.full(len(q), "t"), np.array(q), np.array(payload_kg or [0.0] * len(q))))
    return str(path)


def refusal(bench: Path, plan: str, out: Path, **more: Any) -> str:
    with pytest.raises(InputError) as caught:
        capture_command(str(bench), plan, out, **more)
    message = str(caught.value)
    assert "\n" not in message
    assert "no-port" not in message
    return message


def test_plan_outside_the_limits_is_refused_by_line_and_joint(bench: Path, tmp_path: Path):
    plan = plan_file(tmp_path, [[0, 0, 0], [0, 0.4, 0], [0, 0.8, 0], [0, 1.25, 0]])

    assert "plan.csv: line 5 (t): joint 2 at 1.2500 rad" in refusal(bench, plan, tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_plan_with_too_long_a_step_is_refused(bench: Path, tmp_path: Path):
    plan = plan_file(tmp_path, [[0, 0, 0], [0, 0.6, 0]])

    assert "line 3 (t): joint 2 turns 0.6000 rad in one step" in refusal(bench, plan, tmp_path / "out")


def test_pose_out_of_reach_is_refused_with_the_reach(bench: Path, tmp_path: Path):
    plan = tmp_path / "poses.csv"
    plan.write_text("trajectory,x_mm,y_mm,theta_rad\nt,-130,40,3.14159\nt,-400,40,3.14159\n")

    with pytest.raises(UnreachablePoseError, match=r"poses.csv: pose 1 .* out of reach.*1.70 to 241.70 mm"):
        capture_command(str(bench), str(plan), tmp_path / "out")


def test_plan_in_degrees_is_refused(bench: Path, tmp_path: Path):
    assert "look like degrees" in refusal(bench, plan_file(tmp_path, [[10, 20, 30]]), tmp_path / "out")


def test_missing_plan_names_the_built_in_one(bench: Path, tmp_path: Path):
    assert "give a CSV, or one of paper" in refusal(bench, "papers", tmp_path / "out")


def test_folder_with_another_arms_data_is_refused(bench: Path, tmp_path: Path):
    here = read_bench(bench)
    other = replace(nominal_arm(), link_lengths_mm=np.array([100.0, 100.0, 38.0, 6.73]))
    poses = Plan(np.array(["t"]), np.zeros((1, 3)), np.zeros(1))
    there = CaptureFolder(tmp_path / "out", replace(here.description, arm=other), poses)
    there.open()
    there.close()

    with pytest.raises(RecordingError, match="holds another arm's data"):
        capture_command(str(bench), plan_file(tmp_path, [[0, 0, 0]]), tmp_path / "out")


def test_unknown_held_out_trajectory_is_refused(bench: Path, tmp_path: Path):
    plan = plan_file(tmp_path, [[0, 0, 0]])

    assert "no trajectory 'line'; it has t" in refusal(bench, plan, tmp_path / "out", hold_out=["line"])


def test_a_payload_needs_a_person(bench: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    plan = plan_file(tmp_path, [[0, 0, 0], [0, 0, 0]], [0.0, 0.05])
    with (tmp_path / "empty").open("w+") as nobody:
        monkeypatch.setattr("sys.stdin", nobody)

        assert "needs a person at the terminal" in refusal(bench, plan, tmp_path / "out")


def test_a_port_that_is_not_there_is_named_only_when_all_else_is_right(bench: Path, tmp_path: Path):
    with pytest.raises(InputError, match=r"serial port .*no-port: it does not exist"):
        capture_command(str(bench), plan_file(tmp_path, [[0, 0, 0]]), tmp_path / "out")


def test_a_port_that_is_not_there_leaves_nothing_behind(bench: Path, tmp_path: Path):
    plan = plan_file(tmp_path, [[0, 0, 0]])
    before = sorted(tmp_path.rglob("*"))

    with pytest.raises(InputError, match="no-port"):
        capture_command(str(bench), plan, tmp_path / "new" / "out")

    assert sorted(tmp_path.rglob("*")) == before


def test_a_folder_that_cannot_be_written_is_refused_before_the_port_is_opened(bench: Path, tmp_path: Path):
    (tmp_path / "file").touch()

    assert "is a file" in refusal(bench, plan_file(tmp_path, [[0, 0, 0]]), tmp_path / "file" / "out")


def test_the_papers_plan_lies_within_the_limits_of_a_usual_bench(setup: BenchSetup):
    setup.limits.check_plan(load_plan("paper", setup.arm), "paper")
