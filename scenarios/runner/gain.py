"""The validation trajectory three times: uncorrected, by the calibrated geometry, and by the extended twin."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from armtwin.models.recordings.reader import camera_from_table
from armtwin.models.validation import CameraTable, check
from armtwin.scenarios import paper_values as paper
from armtwin.scenarios.runner.job import Job
from armtwin.scenarios.runner.measure import recorded
from armtwin.scenarios.runner.stage import Tick
from armtwin.scenarios.runner.validation import line_run, true_tip

Array = NDArray[np.float64]

RUNS = ("before", "after", "extended")
_PAPER_MEAN_MM = {"before": paper.VALIDATION["mean_before_mm"], "after": paper.VALIDATION["mean_after_mm"]}
_BOOTSTRAPS = 2000
# Poses that follow one another share their errors; they are resampled together.
_BLOCK = 5


def measure_gain(job: Job, tick: Tick) -> dict[str, Any]:
    """Compare the errors on the validation trajectory; intervals are bootstrapped over stretches of it."""
    before, extended = recorded(job, "before"), recorded(job, "extended")
    path = job.scenario.trajectories[job.scenario.validate_on].poses()[:, :2]
    true_mm = true_tip(job, "extended", extended, earlier=before)
    run = line_run(extended, np.arange(len(extended)), path, true_mm)
    runs = job.load("validation")["runs"] | {"extended": run}
    errors = {name: np.array(runs[name]["error_mm"], dtype=float) for name in RUNS}
    diagnosis = job.load("diagnose")
    camera = camera_from_table(check(CameraTable, diagnosis["camera"], "stages/diagnose.json"))
    recordings = {"before": before, "after": recorded(job, "after"), "extended": extended}
    by_twin = {}
    for name, recording in recordings.items():
        lines = np.flatnonzero(recording.trajectory == job.scenario.validate_on)
        true_line = np.array(runs[name]["true_mm"])
        by_twin[name] = line_run(replace(recording, camera=camera), lines, path, true_line)["mean_mm"]
    tick(1, 1)
    return {
        "trajectory": job.scenario.validate_on,
        "verdict": diagnosis["found"]["verdict"],
        "corrected_with": [active["label"] for active in diagnosis["corrected_with"]],
        "corrected_camera": any(active["where"] == "camera" for active in diagnosis["corrected_with"]),
        "rows": [{**_row(name, runs[name], errors), "mean_by_twin_camera_mm": by_twin[name]} for name in RUNS],
        "noise_floor_mm": noise_floor_mm(diagnosis["found"]["held_out"]["noise_floor_mm"]),
        "run": run,
    }


def noise_floor_mm(marker_rms_mm: float) -> float:
    """Return the mean error, mm, that would be measured of a tip that is exactly where it should be.

    `marker_rms_mm` is the RMS distance by which a marker is mis-seen. The tip is measured from marker A, mis-seen
    alike, so the RMS is sqrt(2) times that; the mean length of a vector with two normal parts is sqrt(pi)/2 of its RMS.
    """
    return float(np.sqrt(2.0) * np.sqrt(np.pi) / 2.0 * marker_rms_mm)


def _row(name: str, run: dict[str, Any], errors: dict[str, Array]) -> dict[str, Any]:
    error = errors[name]
    mean, less = reduction(errors["before"], error)
    return {
        "run": name,
        "paper_mean_mm": _PAPER_MEAN_MM.get(name),
        "mean_mm": run["mean_mm"],
        "std_of_mean_mm": run["std_of_mean_mm"],
        "mean_ci95_mm": mean,
        "std_mm": np.nanstd(error, ddof=1) if np.isfinite(error).sum() > 1 else None,
        "max_mm": run["max_mm"],
        "true_mean_mm": run["true_mean_mm"],
        "vision_error_mm": run["vision_error_mm"],
        "reduction_percent": _reduction_percent(run["mean_mm"], errors["before"]),
        "reduction_ci95_percent": less,
    }


def _reduction_percent(mean_mm: float | None, before: Array) -> float | None:
    """Return by how much the mean error is below the uncorrected one; None where the tip was not seen."""
    if mean_mm is None or not np.isfinite(before).any():
        return None
    return float(100.0 * (1.0 - mean_mm / np.nanmean(before)))


def reduction(before: Array, error: Array) -> tuple[Array, Array]:
    """95 % intervals of the mean error, mm, and of the percentage that it is below the uncorrected one.

    NaN where no pose of both was seen.
    """
    both = np.isfinite(before) & np.isfinite(error)
    b, e = before[both], error[both]
    if not len(b):
        return np.full(2, np.nan), np.full(2, np.nan)
    starts = np.arange(0, len(b), _BLOCK)
    sizes = np.diff([*starts, len(b)])
    draws = np.random.default_rng(0).integers(0, len(starts), (_BOOTSTRAPS, len(starts)))
    drawn_b, drawn_e = (np.add.reduceat(values, starts)[draws].sum(axis=1) for values in (b, e))
    mean = drawn_e / sizes[draws].sum(axis=1)
    less = 100.0 * (1.0 - drawn_e / drawn_b)
    return np.percentile(mean, [2.5, 97.5]), np.percentile(less, [2.5, 97.5])
