"""Diagnose, run the proposed experiment on the bench, diagnose again, until nothing more can be told."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.random import Generator

from armtwin.calib.diagnosis.diagnosis import Diagnosis, diagnose
from armtwin.calib.diagnosis.experiment import Experiment, propose
from armtwin.calib.diagnosis.holdout import held_out_rows
from armtwin.models.bench import Bench
from armtwin.models.errors import InputError
from armtwin.models.inverse_kinematics import inverse
from armtwin.models.plan import Plan, paper_plan, plan_of
from armtwin.models.recordings.recording import Recording, make_samples
from armtwin.models.world import World
from armtwin.scenarios.benches.door import open_bench
from armtwin.scenarios.benches.experiments import check_same_bench, followed_by, recorded_on
from armtwin.scenarios.benches.spec import BenchSpec, SimulatedSpec
from armtwin.scenarios.runner.world import build_world, declared_arm
from armtwin.scenarios.scenario import ScenarioFile
from armtwin.sim.observe import make_recording, pixels_of
from armtwin.sim.physics.simulation import default_clock, simulate

# What the sub-pixel detector leaves of a good picture, px: the noise where a recording states none.
_NOISE_PX = 0.06
# Each round takes a diagnosis; causes that three experiments have not parted will hardly be parted by a fourth.
MOST_ROUNDS = 4
# The paper validates on its line (section 4).
PAPER_VALIDATION = "line"


@dataclass(frozen=True, eq=False)
class Round:
    """A recording, what was found in it, and what was proposed to be run next (None: nothing more can be told)."""

    recording: Recording
    diagnosis: Diagnosis
    experiment: Experiment | None


# Runs a plan on the bench on which a recording was made, as round so many, and returns the recording with it appended.
Experimenter = Callable[[Recording, Plan, int], Recording]


def close_loop(
    run: Experimenter,
    recording: Recording,
    *,
    most_rounds: int = MOST_ROUNDS,
    tell: Callable[[str], None] = lambda _: None,
) -> list[Round]:
    """Diagnose and experiment by turns on the bench on which `recording` was made; the last round decides.

    Ends where nothing ties, where no plan that the bench can run alone would tell more, or after `most_rounds`.
    """
    recording = _with_held_out(recording)
    rounds: list[Round] = []
    while True:
        tell(f"round {len(rounds) + 1}: diagnosing {len(recording)} poses")
        diagnosis = diagnose(recording, tell)
        experiment = propose(diagnosis)
        rounds.append(Round(recording, diagnosis, experiment))
        if experiment is None or not experiment.appends or len(rounds) == most_rounds:
            return rounds
        tell(f"round {len(rounds)}: running {experiment.trajectory}, {len(experiment.plan)} poses")
        recording = run(recording, experiment.plan, len(rounds))


def on_world(world: World, seed: int = 0) -> Experimenter:
    """Return what runs plans in a simulated world, without pictures."""
    return lambda recording, plan, number: go_on(world, recording, plan, np.random.default_rng([seed, number]))


def on_bench(bench: Bench, out: Path) -> Experimenter:
    """Return what runs plans on a connected bench, each recorded in a folder of its own below `out`."""

    def run(recording: Recording, plan: Plan, number: int) -> Recording:
        more = recorded_on(bench, plan, out / f"round-{number}", recording.q_cmd[-1])
        return followed_by(recording, more)

    return run


def record_scenario(scenario: ScenarioFile) -> tuple[World, Recording]:
    """Return a scenario's bench and the recording of its trajectories on it, the validation's held out."""
    world, arm = build_world(scenario), declared_arm(scenario)
    plan = plan_of({name: inverse(arm, path.poses()) for name, path in scenario.trajectories.items()})
    clock, rng = default_clock(len(plan)), np.random.default_rng(scenario.seed)
    held_out = (scenario.validate_on,)
    return world, make_recording(world, plan.q_cmd, plan.trajectory, clock, rng, _NOISE_PX, held_out=held_out)


def close_loop_on(
    bench: BenchSpec, recording: Recording | None, out: Path, tell: Callable[[str], None] = lambda _: None
) -> list[Round]:
    """Close the loop on a bench, from `recording` or, where that is None, a scenario's trajectories or the paper's.

    A simulated bench makes the markers' pixels without pictures; any other is opened, and what it records is kept below
    `out`. Raises `InputError` for a recording that was not made on it, and what the bench raises.
    """
    if isinstance(bench, SimulatedSpec):
        scenario = bench.scenario
        if recording is None:
            tell("recording the scenario's trajectories")
            recording = record_scenario(scenario)[1]
        return close_loop(on_world(build_world(scenario), scenario.seed), recording, tell=tell)
    opened = open_bench(bench)
    if recording is not None:
        check_same_bench(opened, recording)
    with opened:
        if recording is None:
            tell("recording the paper's trajectories")
            plan = paper_plan(opened.description.arm)
            recording = replace(recorded_on(opened, plan, out / "first"), held_out=(PAPER_VALIDATION,))
        else:
            tell("going to where the recording ended")
            opened.move(recording.q_cmd[-1])
        return close_loop(on_bench(opened, out), recording, tell=tell)


def described(one: Round) -> str:
    """Say in a line what a round found and what was run because of it."""
    diagnosis, experiment = one.diagnosis, one.experiment
    causes = (" | ".join(a.label for a in (c.active, *c.equivalents)) for c in diagnosis.causes)
    line = f"{len(one.recording)} poses: {diagnosis.verdict}" + "".join(f", {cause}" for cause in causes)
    if experiment is None:
        return line
    return (
        f"{line}; {experiment.trajectory} ({len(experiment.plan)} poses) parts {', '.join(experiment.tells_apart)} "
        f"by {experiment.expected_separation:.0f} standard deviations"
    )


def go_on(world: World, recording: Recording, plan: Plan, rng: Generator) -> Recording:
    """Return the recording with `plan` run after it on the same bench.

    The bench's past decides how its joints stand, so the whole is simulated again; what was recorded stays as it is.
    """
    if not recording.markers_px:
        raise InputError("recording.json: key 'camera' is missing; the simulated bench is watched by a camera")
    n_old, n = len(recording), len(recording) + len(plan)
    # Where no trajectory is held out by name, a new one could be taken for the one to hold out.
    names = plan.trajectory if recording.held_out else np.full(len(plan), recording.trajectory[-1])
    q_cmd = np.concatenate([recording.q_cmd, plan.q_cmd])
    old_payload = np.zeros(n_old) if recording.payload_kg is None else recording.payload_kg
    payload = np.concatenate([old_payload, plan.payload_kg])
    clock, given = default_clock(n), None
    if recording.has_time:
        period = float(np.median(np.diff(recording.time_s))) if n_old > 1 else float(clock[1])
        clock = np.concatenate([recording.time_s, recording.time_s[-1] + period * np.arange(1, len(plan) + 1)])
    if recording.has_time and recording.commanded_s is not None:
        wait = float(np.nanmedian(recording.time_s - recording.commanded_s))
        given = np.concatenate([recording.commanded_s, clock[n_old:] - wait])
    span = float(clock[n_old - 1] - clock[0])
    seen = make_recording(
        world,
        q_cmd,
        np.concatenate([recording.trajectory, names]),
        clock if recording.has_time else None,
        rng,
        recording.pixel_noise_px or _NOISE_PX,
        truth_px=pixels_of(world, simulate(world, q_cmd, clock, payload, given), clock, span),
        markers=tuple(recording.markers_px),
        payload_kg=payload if payload.any() else None,
    )
    markers = {name: np.concatenate([old, seen.markers_px[name][n_old:]]) for name, old in recording.markers_px.items()}
    return replace(
        recording,
        sample=np.concatenate([recording.sample, recording.sample[-1] + 1 + make_samples(len(plan))]),
        time_s=seen.time_s,
        commanded_s=given,
        trajectory=seen.trajectory,
        q_cmd=q_cmd,
        markers_px=markers,
        q_meas=None,
        payload_kg=seen.payload_kg,
        temperature_c=None,
        folder=None,
    )


def _with_held_out(recording: Recording) -> Recording:
    """Keep the same trajectories held out in every round: an experiment is run to be learnt from."""
    _, names, _ = held_out_rows(recording)
    return replace(recording, held_out=names) if names else recording
