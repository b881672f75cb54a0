"""What is served: a bench by kind, with what a visitor may know of it before it is opened."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from armtwin.hardware.bench.bench_file import BenchSetup, read_bench
from armtwin.hardware.bench.hardware_bench import HardwareBench
from armtwin.models.arm import Arm
from armtwin.models.bench import Bench
from armtwin.models.camera import Camera
from armtwin.models.errors import InputError
from armtwin.models.joint_limits import JointLimits
from armtwin.models.kinematics import inverse
from armtwin.models.plan import Plan, plan_of
from armtwin.scenarios.benches.door import Session, open_bench
from armtwin.scenarios.benches.spec import EmulatedSpec, HardwareSpec, SimulatedSpec, bench_spec
from armtwin.scenarios.emulated_bench import EmulatedBench
from armtwin.scenarios.marker_finder import marker_finder
from armtwin.scenarios.plans import load_plan
from armtwin.scenarios.runner.world import build_world, declared_arm
from armtwin.scenarios.scenario import EffectTable, ScenarioFile

# A creeping camera needs to know how long a recording is; a visitor's is about this long.
_VISIT_POSES = 100


@dataclass(frozen=True, eq=False)
class BenchSource:
    """A bench that can be opened, again and again.

    Attributes:
        kind: simulated, emulated or real.
        title: what it is, for people.
        arm, camera, plane_z_mm: as assumed, in the units of a recording.
        limits: of its joints and of a step.
        plans: poses that it offers to run, by name.
        make: opens it with the given faults after so many poses; faults only where `takes_faults`.
        takes_faults: whether faults can be put into it.
        hangs_loads, actuation: as `armtwin.models.bench.BenchDescription` has them.
        release: ends what the source itself started.

    """

    kind: str
    title: str
    arm: Arm
    camera: Camera
    plane_z_mm: float
    limits: JointLimits
    plans: dict[str, Plan]
    make: Callable[[Sequence[EffectTable], int], Bench]
    takes_faults: bool
    hangs_loads: bool
    actuation: Mapping[str, Any]
    release: Callable[[], None]


def source_of(said: str) -> BenchSource:
    """Return the source of `simulated`, a scenario by name or file, `emulated`, or a bench file.

    Raises `InputError` for what is none of them and `JobError` where the emulator cannot be started.
    """
    match bench_spec(said):
        case EmulatedSpec(speed):
            emulated = EmulatedBench(speed=speed)
            emulated.start()
            setup = read_bench(emulated.bench_file)
            return _hardware("emulated", "The emulated bench", setup, emulated.close, emulated.hang)
        case HardwareSpec(setup):
            return _hardware("real", Path(said).name, setup, _nothing, None)
        case SimulatedSpec(scenario):
            return _simulated(scenario)
        case _:
            raise InputError(f"--bench: {said[:80]} is served already")


def _simulated(scenario: ScenarioFile) -> BenchSource:
    def make(faults: Sequence[EffectTable], samples_before: int) -> Bench:
        faulty = scenario.model_copy(update={"effects": (*scenario.effects, *faults)})
        try:
            return open_bench(
                SimulatedSpec(faulty),
                Session(n_poses=samples_before + _VISIT_POSES, samples_before=samples_before),
            )
        except ValueError as error:  # MuJoCo's: a spring, a gap or a mass that nothing can have
            raise InputError(f"faults: no such arm can be built ({error})") from None

    arm, world = declared_arm(scenario), build_world(scenario)
    paths = {name: plan_of({name: inverse(arm, path.poses())}) for name, path in scenario.trajectories.items()}
    return BenchSource(
        kind="simulated",
        title=scenario.title,
        arm=arm,
        camera=world.camera,
        plane_z_mm=scenario.bench.arm_plane_z_mm,
        limits=open_bench(SimulatedSpec(scenario)).description.limits,
        plans=paths,
        make=make,
        takes_faults=True,
        hangs_loads=True,
        actuation={"scenario": scenario.fingerprint},
        release=_nothing,
    )


def _hardware(
    kind: str,
    title: str,
    setup: BenchSetup,
    release: Callable[[], None],
    hang_by: Callable[[float], None] | None,
) -> BenchSource:
    finder = marker_finder(setup.arm, setup.camera, setup.arm_plane_z_mm)
    paper = load_plan("paper", setup.arm)
    plans = {str(name): _part(paper, paper.trajectory == name) for name in dict.fromkeys(paper.trajectory)}
    return BenchSource(
        kind=kind,
        title=title,
        arm=setup.arm,
        camera=setup.camera,
        plane_z_mm=setup.arm_plane_z_mm,
        limits=setup.limits,
        plans=plans,
        make=lambda faults, samples_before: HardwareBench(setup, finder, hang_by),
        takes_faults=False,
        hangs_loads=hang_by is not None,
        actuation=setup.description.actuation,
        release=release,
    )


def _part(plan: Plan, rows: NDArray[np.bool_]) -> Plan:
    return Plan(plan.trajectory[rows], plan.q_cmd[rows], plan.payload_kg[rows])


def _nothing() -> None:
    """Release nothing."""
