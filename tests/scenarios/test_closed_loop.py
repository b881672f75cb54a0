"""The closed loop on the simulated bench: a tie is broken by the experiment that was proposed for it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from armtwin.models.kinematics import Deviation
from armtwin.models.plan import Plan, plan_of
from armtwin.models.recordings.recording import Recording
from armtwin.models.world import World
from armtwin.scenarios.cli import main
from armtwin.scenarios.closed_loop import Round, close_loop, described, go_on, on_world, record_scenario
from armtwin.scenarios.scenario import read_scenario
from armtwin.sim.observe import make_recording
from armtwin.sim.physics.simulation import default_clock
from tests.support.worlds import scattered, upright_world, with_effect

DEVIATION = Deviation(np.array([2.0, -3.0, 1.0, 0.0]), np.array([0.02, -0.03, 0.01]))


def plan(q: np.ndarray) -> Plan:
    return plan_of(dict(zip("abcd", np.array_split(q, 4), strict=True)))


def recorded(world: World, of: Plan, noise_px: float, *, timed: bool = False, seed: int = 5) -> Recording:
    clock = default_clock(len(of)) if timed else None
    rng = np.random.default_rng(seed)
    return make_recording(world, of.q_cmd, of.trajectory, clock, rng, noise_px, held_out=("d",))


def said(rounds: list[Round], k: int) -> set[str]:
    """Effects between which round k could not decide."""
    (cause,) = rounds[k].diagnosis.causes
    return {active.effect.name for active in (cause.active, *cause.equivalents)}


def test_play_and_hysteresis_that_tie_on_one_reversal_are_told_apart() -> None:
    q = scattered(60, 5)
    q[:, 1] = np.concatenate([np.linspace(-0.3, 0.4, 30), np.linspace(0.4, -0.3, 30)])
    world = with_effect(upright_world(DEVIATION), "backlash", {"width_rad": 0.012}, joint=2)
    rounds = close_loop(on_world(world), recorded(world, plan(q), 0.1))
    assert said(rounds, 0) == {"backlash", "hysteresis"}
    assert said(rounds, -1) == {"backlash"}
    assert rounds[-1].experiment is None


def test_weight_that_ties_on_few_poses_is_told_by_a_known_mass() -> None:
    springs = {f"compliance{joint}_rad_per_nm": 0.03 for joint in (1, 2, 3)}
    world = with_effect(upright_world(DEVIATION), "payload", {"mass_kg": 0.05, "from_sample": 0, **springs})
    rounds = close_loop(on_world(world), recorded(world, plan(scattered(40, 1)), 0.2))
    assert said(rounds, 0) >= {"gravity_sag", "payload"}
    assert rounds[0].experiment is not None
    assert rounds[0].experiment.plan.payload_kg.any()
    assert said(rounds, -1) == {"payload"}


def test_the_loop_ends_at_once_where_nothing_is_wrong() -> None:
    world = upright_world(DEVIATION)
    rounds = close_loop(on_world(world), recorded(world, plan(scattered(60, 5)), 0.1))
    assert [one.diagnosis.verdict for one in rounds] == ["none"]


def test_the_loop_is_bounded() -> None:
    world = with_effect(upright_world(DEVIATION), "backlash", {"width_rad": 0.012}, joint=2)
    q = scattered(60, 5)
    q[:, 1] = np.concatenate([np.linspace(-0.3, 0.4, 30), np.linspace(0.4, -0.3, 30)])
    assert len(close_loop(on_world(world), recorded(world, plan(q), 0.1), most_rounds=1)) == 1


def test_what_was_recorded_stays_as_it_is_when_the_bench_goes_on() -> None:
    world = with_effect(upright_world(), "thermal_drift", {"drift_rad": 0.05, "time_constant_s": 40.0}, joint=1)
    first = recorded(world, plan(scattered(20, 2)), 0.1, timed=True)
    longer = go_on(world, first, plan(scattered(8, 3)), np.random.default_rng(1))
    assert len(longer) == 28
    assert (longer.markers_px["f"][:20] == first.markers_px["f"]).all()
    assert np.diff(longer.time_s) == pytest.approx(np.full(27, 1.5))


def test_the_bench_goes_on_from_where_it_stood() -> None:
    world = with_effect(upright_world(), "joint_slip", {"jump_rad": 0.1, "from_sample": 10}, joint=1)
    whole = plan(scattered(24, 2))
    first = recorded(world, plan(whole.q_cmd[:16]), 1e-6)
    rest = Plan(np.full(8, "e"), whole.q_cmd[16:], np.zeros(8))
    longer = go_on(world, first, rest, np.random.default_rng(1))
    at_once = recorded(world, whole, 1e-6)
    assert longer.markers_px["f"][16:] == pytest.approx(at_once.markers_px["f"][16:], abs=1e-4)


def test_a_camera_goes_on_creeping_without_a_jump() -> None:
    world = with_effect(upright_world(), "camera_drift", {"rotation_z_rad": 0.02})
    still = np.zeros((21, 3))
    first = recorded(world, plan(still), 1e-9, timed=True)
    longer = go_on(world, first, plan(still[:20]), np.random.default_rng(1))
    steps = np.linalg.norm(np.diff(longer.markers_px["f"], axis=0), axis=1)
    assert steps[20] == pytest.approx(steps[19], rel=0.1)
    assert (steps[20:] > 0.2 * steps[19]).all()


def test_a_new_trajectory_is_never_the_one_that_is_held_out() -> None:
    world = with_effect(upright_world(DEVIATION), "backlash", {"width_rad": 0.012}, joint=2)
    q = scattered(60, 5)
    q[:, 1] = np.concatenate([np.linspace(-0.3, 0.4, 30), np.linspace(0.4, -0.3, 30)])
    whole = plan(q)
    rng = np.random.default_rng(5)
    undeclared = make_recording(world, whole.q_cmd, whole.trajectory, None, rng, 0.1)
    rounds = close_loop(on_world(world), undeclared, most_rounds=2)
    assert {one.diagnosis.held_out.trajectories for one in rounds} == {("d",)}


def test_a_scenario_is_recorded_on_its_own_bench() -> None:
    scenario = read_scenario("paper")
    world, recording = record_scenario(scenario)
    assert recording.held_out == ("line",)
    assert list(dict.fromkeys(recording.trajectory)) == list(scenario.trajectories)
    assert world.arm is recording.arm


def test_a_round_is_told_in_a_line() -> None:
    world = upright_world(DEVIATION)
    (one,) = close_loop(on_world(world), recorded(world, plan(scattered(60, 5)), 0.1))
    assert described(one) == "60 poses: none"


def test_neither_recording_nor_bench_is_refused_in_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as left:
        main(["diagnose", "--out", str(tmp_path / "out")])
    assert left.value.code == 2
    assert capsys.readouterr().err.splitlines() == [
        "armtwin: RECORDING is missing; give a recording's folder, or --bench BENCH"
    ]
