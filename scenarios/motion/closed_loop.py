"""Diagnose a moving arm, run the proposed motions on its bench, diagnose again, until nothing more can be told."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from armtwin.calib.markers import measure_recording
from armtwin.calib.motion.diagnosis import MotionDiagnosis, diagnose_motion
from armtwin.calib.motion.experiment import NextMotion, propose_motion
from armtwin.hardware.capture.film import film
from armtwin.models.arm import Arm
from armtwin.models.bench import FilmingBench
from armtwin.models.errors import InputError
from armtwin.models.motion_world import Motion
from armtwin.models.plan import Plan
from armtwin.models.recordings.moving import MovingRecording
from armtwin.models.recordings.reader import read_recording
from armtwin.models.recordings.writer import arm_table
from armtwin.scenarios.benches.door import open_bench
from armtwin.scenarios.benches.spec import BenchSpec, SimulatedSpec
from armtwin.scenarios.film_angles import angles_of_film
from armtwin.scenarios.runner.world import build_motion_world, declared_arm
from armtwin.scenarios.scenario import ScenarioFile
from armtwin.sim.motion.simulation import simulate_motion

# Each round takes a diagnosis and a minute or two of the arm; what two of them leave open a third seldom closes.
MOST_ROUNDS = 3
# What the sub-pixel detector leaves of a link's direction, rad.
_NOISE_RAD = 3e-4
# The arm rests between what was recorded and what is recorded now.
_PAUSE_S = 5.0

# Runs the proposed motions as round so many, and returns them as a recording of their own.
MotionRunner = Callable[[Plan, int], MovingRecording]


@dataclass(frozen=True, eq=False)
class MotionRound:
    """What was found in a recording, and what was proposed because of it (None: nothing more can be told)."""

    found: MotionDiagnosis
    proposed: NextMotion | None


def close_motion_loop(
    run: MotionRunner,
    recording: MovingRecording,
    *,
    most_rounds: int = MOST_ROUNDS,
    tell: Callable[[str], None] = lambda _: None,
) -> list[MotionRound]:
    """Diagnose and experiment by turns; the last round decides. What is held out stays the same in all of them."""
    rounds: list[MotionRound] = []
    while True:
        number = len(rounds) + 1
        tell(f"round {number}: diagnosing {len(recording)} rows")
        found = diagnose_motion(recording, tell)
        if not recording.held_out:
            recording = replace(recording, held_out=_whole(found))
        proposed = propose_motion(found, number) if number < most_rounds else None
        rounds.append(MotionRound(found, proposed))
        if proposed is None:
            return rounds
        tell(f"round {number}: running {proposed.trajectory}")
        recording = followed_by(recording, run(proposed.plan, number))


def close_motion_loop_on(
    spec: BenchSpec, recording: MovingRecording, out: Path, tell: Callable[[str], None] = lambda _: None
) -> list[MotionRound]:
    """Close the loop on the bench on which a recording was made; a simulated one is not filmed, its joints are read.

    Any other bench is opened, films the motions, and what it filmed is kept below `out`. Raises `InputError` for
    another arm or a bench that does not film, and what the bench raises.
    """
    if isinstance(spec, SimulatedSpec):
        _check_same_arm(declared_arm(spec.scenario), recording)
        return close_motion_loop(on_scenario(spec.scenario), recording, tell=tell)
    bench = open_bench(spec)
    if not isinstance(bench, FilmingBench):
        raise InputError(f"--bench: a {bench.description.kind} bench takes one picture a pose and does not film")
    _check_same_arm(bench.description.arm, recording)
    with bench:
        return close_motion_loop(on_bench(bench, out), recording, tell=tell)


def on_scenario(scenario: ScenarioFile) -> MotionRunner:
    """Return what runs motions in a scenario's world and reads its joints, without pictures."""
    world = build_motion_world(scenario)

    def run(plan: Plan, number: int) -> MovingRecording:
        assert plan.time_s is not None
        rng = np.random.default_rng([scenario.seed, number])
        read = simulate_motion(world, _motions(plan), None, rng)
        read = read + rng.normal(0.0, _NOISE_RAD, read.shape)
        return MovingRecording(declared_arm(scenario), plan.time_s, plan.trajectory, plan.q_cmd, read)

    return run


def on_bench(bench: FilmingBench, out: Path) -> MotionRunner:
    """Return what films motions on a connected bench, each in a folder of its own below `out`."""

    def run(plan: Plan, number: int) -> MovingRecording:
        assert plan.time_s is not None
        folder = out / f"round-{number}"
        bench.description.limits.check_plan(plan, folder.name)
        film(bench, plan, plan.time_s, folder)
        seen = angles_of_film(measure_recording(read_recording(folder, unmeasured=True, film=True)))
        assert seen.q_meas is not None
        return MovingRecording(seen.arm, seen.time_s, seen.trajectory, seen.q_cmd, seen.q_meas, seen.commanded_s)

    return run


def followed_by(first: MovingRecording, more: MovingRecording) -> MovingRecording:
    """Return a recording with another one's motions behind its own, on one clock, with commands and angles alone."""
    shift = float(first.time_s[-1]) + _PAUSE_S - float(more.time_s[0])
    given = [one.time_s if one.commanded_s is None else one.commanded_s for one in (first, more)]
    timed = first.commanded_s is not None or more.commanded_s is not None
    return replace(
        first,
        time_s=np.append(first.time_s, more.time_s + shift),
        commanded_s=np.append(given[0], given[1] + shift) if timed else None,
        trajectory=np.append(first.trajectory, more.trajectory),
        q_cmd=np.concatenate([first.q_cmd, more.q_cmd]),
        q_meas=np.concatenate([first.q_meas, more.q_meas]),
        extras={},
        payload_kg=None,
        temperature_c=None,
        folder=None,
    )


def described(number: int, one: MotionRound) -> str:
    """Say in a line what a round found and what was run because of it."""
    causes = "".join(f", {cause.effect}" + (f" {cause.joint}" if cause.joint else "") for cause in one.found.causes)
    line = f"round {number}: {len(one.found.recording)} rows: {one.found.verdict}{causes}"
    return line if one.proposed is None else f"{line}; {one.proposed.trajectory}, because {one.proposed.why}"


def _whole(found: MotionDiagnosis) -> tuple[str, ...]:
    """Return the motions that were held out as a whole."""
    problem = found.problem
    return tuple(name for name in problem.held_motions if problem.held[problem.recording.rows_of(name)].all())


def _motions(plan: Plan) -> list[Motion]:
    assert plan.time_s is not None
    names = dict.fromkeys(plan.trajectory.tolist())
    rows = [np.flatnonzero(plan.trajectory == name) for name in names]
    return [Motion(name, plan.time_s[own], plan.q_cmd[own]) for name, own in zip(names, rows, strict=True)]


def _check_same_arm(arm: Arm, recording: MovingRecording) -> None:
    if not isinstance(recording.arm, Arm) or arm_table(recording.arm) != arm_table(arm):
        raise InputError("recording.json: key 'arm' is another one than the bench's; record on this bench first")
