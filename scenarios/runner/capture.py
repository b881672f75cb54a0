"""Stages that move the arm and take pictures: before calibration all trajectories, then the validation's twice more."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from armtwin.models.atomic import folder_aside
from armtwin.models.bench import Bench
from armtwin.models.inverse_kinematics import inverse
from armtwin.models.kinematics import Deviation
from armtwin.scenarios.benches.door import Session, open_bench
from armtwin.scenarios.benches.spec import SimulatedSpec
from armtwin.scenarios.runner.frames import Image, write_frame
from armtwin.scenarios.runner.job import Job
from armtwin.scenarios.runner.stage import Tick
from armtwin.scenarios.runner.world import declared_arm
from armtwin.scenarios.scenario import ScenarioFile

Array = NDArray[np.float64]


def capture_before(job: Job, tick: Tick) -> dict[str, Any]:
    """Run every trajectory through the nominal inverse kinematics, one after the other."""
    arm, scenario = declared_arm(job.scenario), job.scenario
    commands = {name: inverse(arm, path.poses()) for name, path in scenario.trajectories.items()}
    return _capture(job, "before", commands, 0, tick)


def capture_after(job: Job, tick: Tick) -> dict[str, Any]:
    """Run the validation trajectory again, through the inverse kinematics of the calibrated arm."""
    found = job.load("calibration")["corrected_with"]
    delta = Deviation(np.array(found["lengths_mm"]), np.array(found["joints_rad"]))
    name = job.scenario.validate_on
    poses = job.scenario.trajectories[name].poses()
    commands = {name: inverse(declared_arm(job.scenario), poses, delta=delta)}
    return _capture(job, "after", commands, samples_before(job.scenario, "after"), tick)


def capture_extended(job: Job, tick: Tick) -> dict[str, Any]:
    """Run the validation trajectory again, with the commands of the extended twin.

    Play and friction remember where the arm came from, so it first does, unseen, all that it did in the recording
    that the twin was extended by: there the commands of the extended twin go on.
    """
    name = job.scenario.validate_on
    commands = {name: np.array(job.load("diagnose")["q_cmd_rad"])}
    approach = np.array(job.load("capture_before")["q_cmd_rad"])
    return _capture(job, "extended", commands, samples_before(job.scenario, "extended"), tick, approach)


def samples_before(scenario: ScenarioFile, recording: str) -> int:
    """Return how many poses the bench has run before a recording of this run."""
    first, line = (
        sum(path.samples for path in scenario.trajectories.values()),
        scenario.trajectories[scenario.validate_on],
    )
    return {"before": 0, "after": first, "extended": first + line.samples}[recording]


def _capture(
    job: Job, recording: str, commands: dict[str, Array], earlier: int, tick: Tick, approach: Array | None = None
) -> dict[str, Any]:
    """Take one picture a pose into `recordings/<recording>/frames`, all or none of them; none of the `approach`."""
    q_cmd = np.concatenate(list(commands.values()))
    unseen = q_cmd[:0] if approach is None else approach
    session = Session(recording, n_poses=len(unseen) + len(q_cmd), samples_before=earlier)
    bench = open_bench(SimulatedSpec(job.scenario), session)
    with folder_aside(job.recordings / recording / "frames") as folder:
        times = _follow(bench, unseen, q_cmd, lambda number, image: write_frame(folder, number, image), tick)
    return {
        "trajectory": [name for name, q in commands.items() for _ in q],
        "q_cmd_rad": q_cmd,
        "time_s": [seen for seen, _ in times],
        "commanded_s": [given for _, given in times],
    }


def _follow(
    bench: Bench, approach: Array, q_cmd: Array, keep: Callable[[int, Image], None], tick: Tick
) -> list[tuple[float, float | None]]:
    """Return when each pose was seen and commanded, s."""
    times = []
    with bench:
        for q in approach:
            bench.move(q)
        for number, q in enumerate(q_cmd):
            bench.move(q)
            frame = bench.capture()
            keep(number, frame.image)
            times.append((frame.time_s, frame.commanded_s))
            tick(number + 1, len(q_cmd))
    return times
