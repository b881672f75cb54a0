"""What is served: a bench by kind, with what a visitor may know of it before it is opened."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from armtwin.hardware.bench.bench_file import BenchSetup, read_bench
from armtwin.hardware.bench.hardware_bench import HardwareBench
from armtwin.hardware.bench.limits import JointLimits
from armtwin.models.arm import Arm
from armtwin.models.bench import Bench
from armtwin.models.camera import Camera
from armtwin.models.errors import InputError
from armtwin.models.kinematics import inverse
from armtwin.models.plan import Plan, plan_of
from armtwin.scenarios.emulated_bench import EmulatedBench
from armtwin.scenarios.marker_finder import marker_finder
from armtwin.scenarios.plans import load_plan
from armtwin.scenarios.runner.bench import simulated_bench
from armtwin.scenarios.runner.world import build_world, declared_arm
from armtwin.scenarios.scenario import EffectTable, ScenarioFile, read_scenario

SIMULATED, EMULATED = "simulated", "emulated"
# The bench of `--bench simulated`: an ideal arm as drawn, into which the visitor puts the faults.
IDEAL_SCENARIO = "ideal"
# A creeping camera needs to know how long a recording is; a visitor's is about this long.
_VISIT_POSES = 100
# Joints of a simulated arm turn as far as a hobby servo does, which is also what the drawn arm can show.
_TURN_RAD = np.radians(90.0)


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
    release: Callable[[], None]


def source_of(spec: str) -> BenchSource:
    """Return the source of `simulated`, a scenario by name or file, `emulated`, or a bench file.

    Raises `InputError` for what is none of them and `JobError` where the emulator cannot be started.
    """
    if spec == EMULATED:
        emulated = EmulatedBench()
        emulated.start()
        return _hardware(EMULATED, "The emulated bench", read_bench(emulated.bench_file), emulated.close)
    path = Path(spec)
    if path.suffix == ".toml" and path.is_file() and "armtwin.bench/" in path.read_text("utf-8", errors="replace"):
        return _hardware("real", path.name, read_bench(path), _nothing)
    return _simulated(read_scenario(IDEAL_SCENARIO if spec == SIMULATED else spec))


def _simulated(scenario: ScenarioFile) -> BenchSource:
    def make(faults: Sequence[EffectTable], samples_before: int) -> Bench:
        faulty = scenario.model_copy(update={"effects": (*scenario.effects, *faults)})
        try:
            return simulated_bench(faulty, "serve", samples_before + _VISIT_POSES, samples_before)
        except ValueError as error:  # MuJoCo's: a spring, a gap or a mass that nothing can have
            raise InputError(f"faults: no such arm can be built ({error})") from None

    arm, world = declared_arm(scenario), build_world(scenario)
    paths = {name: plan_of({name: inverse(arm, path.poses())}) for name, path in scenario.trajectories.items()}
    turn = np.full(arm.n_joints, _TURN_RAD)
    return BenchSource(
        kind=SIMULATED,
        title=scenario.title,
        arm=arm,
        camera=world.camera,
        plane_z_mm=scenario.bench.arm_plane_z_mm,
        limits=JointLimits(-turn, turn, 2 * _TURN_RAD),
        plans=paths,
        make=make,
        takes_faults=True,
        release=_nothing,
    )


def _hardware(kind: str, title: str, setup: BenchSetup, release: Callable[[], None]) -> BenchSource:
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
        make=lambda faults, samples_before: HardwareBench(setup, finder),
        takes_faults=False,
        release=release,
    )


def _part(plan: Plan, rows: NDArray[np.bool_]) -> Plan:
    return Plan(plan.trajectory[rows], plan.q_cmd[rows], plan.payload_kg[rows])


def _nothing() -> None:
    """Release nothing."""
