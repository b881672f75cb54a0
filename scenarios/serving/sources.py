"""What is served: a bench by kind, with what a visitor may know of it before it is opened."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from armtwin.hardware.bench.bench_file import BenchSetup, read_bench
from armtwin.models.bench import Bench, BenchDescription
from armtwin.models.errors import InputError
from armtwin.models.inverse_kinematics import inverse
from armtwin.models.plan import Plan, plan_of
from armtwin.scenarios.benches.door import Session, open_bench
from armtwin.scenarios.benches.spec import EmulatedSpec, HardwareSpec, SimulatedSpec, bench_spec
from armtwin.scenarios.emulated_bench import EmulatedBench
from armtwin.scenarios.plans import load_plan
from armtwin.scenarios.runner.world import declared_arm
from armtwin.scenarios.scenario import EffectTable, ScenarioFile
from armtwin.scenarios.serving.pace import Pace

# A creeping camera needs to know how long a recording is; a visitor's is about this long.
_VISIT_POSES = 100


@dataclass(frozen=True, eq=False)
class Terms:
    """On what terms a visitor has a bench: how many `pictures` in all, every one of them kept in one recording, which
    `tools` he may call, who is `told` of each command, and the `pace` that hides how long the bench takes."""

    pictures: Callable[[], int]
    tools: tuple[str, ...]
    told: Callable[[dict[str, Any]], None]
    pace: Pace


@dataclass(frozen=True, eq=False)
class BenchSource:
    """A bench that can be opened, again and again.

    Attributes:
        title: what it is, for people.
        description: what the bench says of itself.
        plans: poses that it offers to run, by name.
        make: opens it with the given faults after so many poses; faults only where `takes_faults`.
        takes_faults: whether faults can be put into it.
        release: ends what the source itself started.
        terms: on what terms; None: as many pictures as one likes.

    """

    title: str
    description: BenchDescription
    plans: dict[str, Plan]
    make: Callable[[Sequence[EffectTable], int], Bench]
    takes_faults: bool
    release: Callable[[], None]
    terms: Terms | None = None


def source_of(said: str) -> BenchSource:
    """Return the source of `simulated`, a scenario by name or file, `emulated`, or a bench file.

    Raises `InputError` for what is none of them and `JobError` where the emulator cannot be started.
    """
    match bench_spec(said):
        case EmulatedSpec(speed, arm):
            emulated = EmulatedBench(speed=speed, arm=arm)
            emulated.start()
            return _hardware("The emulated bench", read_bench(emulated.bench_file), emulated)
        case HardwareSpec(setup):
            return _hardware(Path(said).name, setup)
        case SimulatedSpec(scenario):
            return _simulated(scenario)
        case _:
            raise InputError(f"--bench: {said[:80]} is served already")


def _simulated(scenario: ScenarioFile) -> BenchSource:
    def make(faults: Sequence[EffectTable], samples_before: int) -> Bench:
        faulty = scenario.model_copy(update={"effects": (*scenario.effects, *faults)})
        session = Session(n_poses=samples_before + _VISIT_POSES, samples_before=samples_before)
        try:
            return open_bench(SimulatedSpec(faulty), session)
        except InputError as error:
            raise InputError(f"faults: {error}") from None

    arm = declared_arm(scenario)
    return BenchSource(
        title=scenario.title,
        description=open_bench(SimulatedSpec(scenario)).description,
        plans={name: plan_of({name: inverse(arm, path.poses())}) for name, path in scenario.trajectories.items()},
        make=make,
        takes_faults=True,
        release=_nothing,
    )


def _hardware(title: str, setup: BenchSetup, emulated: EmulatedBench | None = None) -> BenchSource:
    hang_by = None if emulated is None else emulated.hang
    paper = load_plan("paper", setup.arm)

    def make(faults: Sequence[EffectTable], samples_before: int) -> Bench:
        return open_bench(HardwareSpec(setup), hang_by=hang_by)

    return BenchSource(
        title=title,
        description=replace(make((), 0).description, kind="hardware" if emulated is None else "emulated"),
        plans={str(name): _part(paper, paper.trajectory == name) for name in dict.fromkeys(paper.trajectory)},
        make=make,
        takes_faults=False,
        release=_nothing if emulated is None else emulated.close,
    )


def _part(plan: Plan, rows: NDArray[np.bool_]) -> Plan:
    return Plan(plan.trajectory[rows], plan.q_cmd[rows], plan.payload_kg[rows])


def _nothing() -> None:
    """Release nothing."""
