"""The validation line before and after the calibration (Figures 5 and 6), as measured and as it truly was."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from armtwin.calib.arm.algorithm_1 import measured_tip
from armtwin.models.recordings.recording import Recording
from armtwin.scenarios.runner.capture import samples_before
from armtwin.scenarios.runner.job import Job
from armtwin.scenarios.runner.measure import recorded
from armtwin.scenarios.runner.stage import Tick
from armtwin.scenarios.runner.world import build_world
from armtwin.sim.physics.simulation import simulate

Array = NDArray[np.float64]


def validate(job: Job, tick: Tick) -> dict[str, Any]:
    """Compare the tip's measured and true path with the commanded one, before and after."""
    path = job.scenario.trajectories[job.scenario.validate_on].poses()[:, :2]
    runs = {}
    for number, name in enumerate(("before", "after")):
        recording = recorded(job, name)
        rows = np.flatnonzero(recording.trajectory == job.scenario.validate_on)
        runs[name] = line_run(recording, rows, path, true_tip(job, name, recording)[rows])
        tick(number + 1, 2)
    before, after = runs["before"]["mean_mm"], runs["after"]["mean_mm"]
    return {
        "trajectory": job.scenario.validate_on,
        "commanded_mm": path,
        "runs": runs,
        "mean_before_mm": before,
        "mean_after_mm": after,
        "reduction_percent": 100.0 * (1.0 - after / before),
    }


def line_run(recording: Recording, rows: NDArray[np.int64], path: Array, true_mm: Array) -> dict[str, Any]:
    """Equations (11) and (19) on one run of the line; poses without A or F are null and left out of the means."""
    seen_mm, seen_rows, _ = measured_tip(recording, rows)
    measured = np.full((len(rows), 2), np.nan)
    measured[np.searchsorted(rows, seen_rows)] = seen_mm
    error = np.linalg.norm(measured - path, axis=1)
    true_error = np.linalg.norm(true_mm - path, axis=1)
    return {
        "measured_mm": measured,
        "true_mm": true_mm,
        "error_mm": error,
        "true_error_mm": true_error,
        "mean_mm": np.nanmean(error),
        "std_of_mean_mm": np.nanstd(error, ddof=1) / np.sqrt(np.isfinite(error).sum()),
        "max_mm": np.nanmax(error),
        "true_mean_mm": true_error.mean(),
        "vision_error_mm": np.sqrt(np.nanmean(((measured - true_mm) ** 2).sum(axis=1))),
    }


def true_tip(job: Job, name: str, recording: Recording, earlier: Recording | None = None) -> Array:
    """(N, 2) where the simulated arm's tip truly was relative to A, robot mm: what no bench can tell.

    `earlier` is what the same bench had done, unseen, since it was switched on.
    """
    world = build_world(job.scenario, samples_before(job.scenario, name))
    done = [recording] if earlier is None else [earlier, recording]
    q_cmd, seen_s = np.concatenate([r.q_cmd for r in done]), np.concatenate([r.time_s for r in done])
    given = [r.commanded_s for r in done if r.commanded_s is not None]
    points = simulate(world, q_cmd, seen_s, commanded_s=np.concatenate(given) if len(given) == len(done) else None)
    column = world.arm.known_markers.index(recording.arm.marker_names[-1])
    tip: Array = points[-len(recording) :, column, :2]
    return tip
