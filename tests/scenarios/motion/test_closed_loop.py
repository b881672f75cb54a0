"""The next experiment of a moving arm: a plan with times that a bench executes, and after it the tie is gone."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from armtwin.calib.motion.diagnosis import diagnose_motion
from armtwin.calib.motion.experiment import NextMotion, propose_motion
from armtwin.models.motion.excitation import excitation
from armtwin.models.plan import Plan, read_plan, write_plan
from armtwin.models.recordings.moving import MovingRecording
from armtwin.models.recordings.moving_reader import read_moving
from armtwin.models.recordings.moving_writer import write_moving_recording
from armtwin.scenarios.benches.spec import SimulatedSpec, bench_spec
from armtwin.scenarios.cli import main
from armtwin.scenarios.motion.closed_loop import on_scenario

IDEAL = Path(__file__).parents[3] / "scenarios" / "files" / "ideal.toml"
PLAY = '\n[[moving_effects]]\nname = "backlash"\njoint = 2\nwidth_rad = 0.02\n'


@pytest.fixture(scope="module")
def bench(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a scenario of an arm with play at joint 2."""
    path = tmp_path_factory.mktemp("bench") / "play.toml"
    path.write_text(IDEAL.read_text("utf-8") + PLAY, "utf-8")
    return path


@pytest.fixture(scope="module")
def one_turn(bench: Path) -> MovingRecording:
    """Return a log in which joint 2 turns back once: play there looks like friction."""
    spec = bench_spec(str(bench))
    assert isinstance(spec, SimulatedSpec)
    t = np.arange(0.0, 8.0, 0.02)
    q = 0.4 * np.sin(2 * np.pi * 0.06 * t)
    plan = Plan(np.full(len(t), "slow"), np.stack([0.5 * q, q, -q], axis=1), np.zeros(len(t)), t)
    return on_scenario(spec.scenario)(plan, 0)


@pytest.fixture(scope="module")
def proposed(one_turn: MovingRecording) -> NextMotion:
    found = propose_motion(diagnose_motion(one_turn))
    assert found is not None
    return found


def test_what_ties_is_asked_by_the_motions_that_show_it(proposed: NextMotion) -> None:
    assert proposed.joints == (2,)
    assert {"friction", "backlash"} <= set(proposed.tells_apart)
    assert {"reversals_2_round_1", "holds_2_round_1"} <= set(proposed.plan.trajectory.tolist())


def test_its_plan_is_one_that_a_bench_may_run(proposed: NextMotion, one_turn: MovingRecording, tmp_path: Path) -> None:
    plan = proposed.plan
    assert plan.time_s is not None
    assert np.allclose(np.diff(plan.time_s), 0.02)
    assert np.abs(np.diff(plan.q_cmd, axis=0)).max() < 0.5
    assert np.abs(plan.q_cmd[0] - one_turn.q_cmd[-1]).max() < 0.5
    low, high = one_turn.q_cmd.min(axis=0), one_turn.q_cmd.max(axis=0)
    assert (plan.q_cmd > low - 1e-9).all()
    assert (plan.q_cmd < high + 1e-9).all()
    write_plan(tmp_path / "next.csv", plan)
    again = read_plan(tmp_path / "next.csv", 3)
    np.testing.assert_array_equal(again.time_s, plan.time_s)
    np.testing.assert_array_equal(again.q_cmd, plan.q_cmd)


@pytest.mark.parametrize("kind", ["chirp", "steps", "reversals", "holds"])
@pytest.mark.parametrize("rate_hz", [15.0, 50.0])
def test_every_motion_begins_and_ends_at_rest_in_the_middle_and_stays_inside(kind: str, rate_hz: float) -> None:
    q = excitation(kind, -0.2, 0.8, rate_hz)
    assert abs(q[0] - 0.3) < 0.1
    assert q[-1] == pytest.approx(0.3)
    assert (q >= -0.2 - 1e-12).all()
    assert (q <= 0.8 + 1e-12).all()
    assert np.abs(np.diff(q)).max() < 0.46
    assert np.ptp(q) > 0.3 * (1.0 if kind != "reversals" else 0.9)
    assert np.unique(np.sign(np.diff(q))).tolist() == [-1.0, 0.0, 1.0]


def test_on_its_bench_the_loop_is_closed_and_the_cause_is_named(
    bench: Path, one_turn: MovingRecording, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_moving_recording(tmp_path / "log", one_turn)
    with pytest.raises(SystemExit) as left:
        main(["diagnose", str(tmp_path / "log"), "--bench", str(bench), "--out", str(tmp_path / "out")])
    said = capsys.readouterr().out
    assert left.value.code == 0, said
    assert "round 1: 400 rows: ambiguous" in said
    found = json.loads((tmp_path / "out" / "diagnosis.json").read_text("utf-8"))
    assert [(cause["effect"], cause["joint"]) for cause in found["causes"]] == [("backlash", 2)]
    assert found["verdict"] == "named"
    assert len(read_moving(tmp_path / "out" / "recording")) > 1000
    assert not (tmp_path / "out" / "next_experiment.csv").exists()


def test_what_ties_is_listed_with_a_plan_beside_the_report(
    one_turn: MovingRecording, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_moving_recording(tmp_path / "log", one_turn)
    with pytest.raises(SystemExit):
        main(["diagnose", str(tmp_path / "log"), "--out", str(tmp_path / "out")])
    said = " ".join(capsys.readouterr().out.split())
    assert "Record next (next_experiment.csv, " in said
    table = json.loads((tmp_path / "out" / "diagnosis.json").read_text("utf-8"))["next_experiment"]
    assert {"friction", "backlash"} <= set(table["tells_apart"])
    assert read_plan(tmp_path / "out" / "next_experiment.csv", 3).time_s is not None


def test_a_bench_with_another_arm_is_refused(
    one_turn: MovingRecording, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_moving_recording(tmp_path / "log", one_turn)
    header = json.loads((tmp_path / "log" / "recording.json").read_text("utf-8"))
    header["arm"]["link_lengths_mm"][0] = 99.0
    (tmp_path / "log" / "recording.json").write_text(json.dumps(header), "utf-8")
    with pytest.raises(SystemExit) as left:
        main(["diagnose", str(tmp_path / "log"), "--bench", "ideal", "--out", str(tmp_path / "out")])
    assert left.value.code == 2
    assert "key 'arm' is another one than the bench's" in capsys.readouterr().err
