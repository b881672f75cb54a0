"""The next experiment: proposed where causes tie, within reach, and as telling as promised."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from armtwin.calib.diagnosis.diagnosis import Diagnosis, diagnose
from armtwin.calib.diagnosis.experiment import TELLING, Experiment, propose
from armtwin.calib.diagnosis.experiments.poses import BY_HAND, NAMES, candidates, space_of
from armtwin.calib.diagnosis.experiments.rivals import rivals_of
from armtwin.calib.diagnosis.experiments.separation import confirmed, extended, separations
from armtwin.calib.diagnosis.problem import problem_of
from armtwin.models.arm import Arm
from armtwin.models.catalogue.registry import catalogue
from armtwin.models.kinematics import Deviation
from armtwin.models.plan import MAX_STEP_RAD, Plan, plan_of, read_plan, write_plan
from armtwin.models.recordings.recording import Recording, make_samples
from armtwin.models.world import World
from armtwin.sim.observe import make_recording
from tests.support.worlds import scattered, upright_world, with_effect

DEVIATION = Deviation(np.array([2.0, -3.0, 1.0, 0.0]), np.array([0.02, -0.03, 0.01]))


def one_reversal() -> Plan:
    """Joint 2 goes up once and down once: play and friction-held lag look alike."""
    q = scattered(60, 5)
    q[:, 1] = np.concatenate([np.linspace(-0.3, 0.4, 30), np.linspace(0.4, -0.3, 30)])
    return plan_of({name: q[15 * k : 15 * k + 15] for k, name in enumerate("abcd")})


def diagnosed(world: World, plan: Plan, noise_px: float = 0.1) -> Diagnosis:
    rng = np.random.default_rng(5)
    return diagnose(make_recording(world, plan.q_cmd, plan.trajectory, None, rng, noise_px, held_out=("d",)))


@pytest.fixture(scope="module")
def tie() -> Diagnosis:
    """Return a diagnosis that cannot tell play from hysteresis."""
    found = diagnosed(with_effect(upright_world(DEVIATION), "backlash", {"width_rad": 0.012}, joint=2), one_reversal())
    assert found.verdict == "ambiguous"
    return found


@pytest.fixture(scope="module")
def proposed(tie: Diagnosis) -> Experiment:
    """Return what is proposed for it."""
    experiment = propose(tie)
    assert experiment is not None
    return experiment


def test_a_tie_is_answered_by_a_plan_for_the_joint_in_question(proposed: Experiment) -> None:
    assert set(proposed.tells_apart) == {"backlash", "hysteresis"}
    moved = np.ptp(proposed.plan.q_cmd, axis=0)
    assert moved[1] > 0.1
    assert moved[[0, 2]] == pytest.approx(0.0)


def test_a_plan_stays_within_the_joints_ranges_but_for_a_small_margin(tie: Diagnosis, proposed: Experiment) -> None:
    seen = tie.problem.context.q_cmd
    margin = np.maximum(0.1 * np.ptp(seen, axis=0), 0.05)
    assert (proposed.plan.q_cmd >= seen.min(axis=0) - margin - 1e-12).all()
    assert (proposed.plan.q_cmd <= seen.max(axis=0) + margin + 1e-12).all()


def test_every_plan_goes_in_steps_that_a_bench_allows(tie: Diagnosis) -> None:
    context = tie.problem.context
    wide = replace(context, q_cmd=3.0 * context.q_cmd)
    space = space_of(wide)
    for candidate in [*candidates(space, (0, 1, 2)), *(make(space) for make in BY_HAND.values())]:
        assert np.abs(np.diff(candidate.q_cmd, axis=0)).max(initial=0.0) <= MAX_STEP_RAD + 1e-9, candidate.name
        assert len(candidate.payload_kg) == len(candidate.q_cmd)


def test_the_experiment_is_said_to_tell_and_why(proposed: Experiment) -> None:
    assert proposed.expected_separation > TELLING
    assert "standard deviations" in proposed.why
    assert proposed.appends
    assert proposed.instructions == ()


def test_the_plan_can_be_written_for_a_bench_and_read_back(proposed: Experiment, tmp_path: Path) -> None:
    write_plan(tmp_path / "next_experiment.csv", proposed.plan)
    again = read_plan(tmp_path / "next_experiment.csv", 3)
    assert set(again.trajectory) == {proposed.trajectory}
    assert (again.q_cmd == proposed.plan.q_cmd).all()


def test_a_new_trajectory_is_named_unlike_those_that_were_run(tie: Diagnosis, proposed: Experiment) -> None:
    assert proposed.trajectory not in tie.problem.context.trajectory


def test_nothing_is_proposed_where_nothing_is_wrong() -> None:
    found = diagnosed(upright_world(DEVIATION), one_reversal())
    assert found.verdict == "none"
    assert propose(found) is None


def test_poses_that_move_another_joint_tell_nothing_of_play(tie: Diagnosis) -> None:
    (group,) = rivals_of(tie)
    data = tie.explanation.data
    by_name = {
        candidate.name: separations(extended(data, candidate, group.models[0]), group)[0, 1]
        for candidate in candidates(space_of(data.problem.context), (0, 1))
    }
    assert by_name["reversal_1"] < 1.0
    assert by_name["reversal_2"] > TELLING


def test_refitting_the_rivals_confirms_what_first_order_promises(tie: Diagnosis) -> None:
    (group,) = rivals_of(tie)
    data = tie.explanation.data
    for candidate in candidates(space_of(data.problem.context), (0, 1)):
        at = extended(data, candidate, group.models[0])
        first, refitted = separations(at, group)[0, 1], confirmed(at, group)[0, 1]
        assert refitted > TELLING or first < 2.0 * TELLING, candidate.name
        assert refitted < TELLING or first > 1.0, candidate.name


def test_every_plan_that_an_effect_asks_for_exists() -> None:
    assert {plan for effect in catalogue().values() for plan in effect.plans} <= set(NAMES)


def test_a_plan_with_a_mass_is_offered_where_gravity_pulls(tie: Diagnosis) -> None:
    space = space_of(tie.problem.context)
    assert space.context.has_gravity
    assert "known_payload" in {candidate.name for candidate in candidates(space, (0,))}


def test_a_known_mass_stands_in_the_plan(tie: Diagnosis) -> None:
    payload = next(c for c in candidates(space_of(tie.problem.context), (0,)) if c.name == "known_payload")
    assert set(payload.payload_kg) == {0.0, 0.1}
    bare, loaded = (payload.q_cmd[payload.payload_kg == mass] for mass in (0.0, 0.1))
    assert (bare == loaded[-len(bare) :]).all()  # before these, poses on the way back to the first
    assert payload.instructions


def test_a_tilted_camera_that_a_tilted_axis_explains_as_well_is_answered_by_calibrating_it_again() -> None:
    world = with_effect(upright_world(DEVIATION), "camera_tilt", {"tilt_x_rad": 0.03, "tilt_y_rad": 0.01})
    plan = plan_of(dict(zip("abcd", np.array_split(scattered(60, 5), 4), strict=True)))
    rng = np.random.default_rng(5)
    seen = make_recording(world, plan.q_cmd, plan.trajectory, None, rng, 0.2, held_out=("d",), markers=("a", "f"))
    found = diagnose(seen)
    assert found.verdict == "ambiguous"
    experiment = propose(found)
    assert experiment is not None
    assert set(experiment.tells_apart) == {"camera_tilt", "axis_tilt"}
    assert not experiment.appends
    assert any("calibrate" in step for step in experiment.instructions)


def test_who_has_no_camera_is_asked_for_no_picture() -> None:
    rng = np.random.default_rng(2)
    q = np.concatenate([np.linspace(0.0, 3.0, 40), np.linspace(2.9, 0.1, 40)])[:, None]
    recording = Recording(
        arm=Arm("servo", np.array([100.0]), np.zeros(2)),
        sample=make_samples(len(q)),
        time_s=np.full(len(q), np.nan),
        trajectory=np.full(len(q), "sweep"),
        q_cmd=q,
        q_meas=q + rng.normal(0.0, 0.002, q.shape),
    )
    plans = candidates(space_of(problem_of(recording).context), (0,))
    assert plans
    assert not any("picture" in plan.name for plan in plans)
