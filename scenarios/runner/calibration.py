"""The arm's calibrations: each calibration trajectory by itself, then all together, by both methods (section 5.2)."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from armtwin.calib.arm import algorithm_1, least_squares
from armtwin.calib.arm.calibration import ArmCalibration
from armtwin.models.arm import Arm
from armtwin.models.kinematics import is_closed_form
from armtwin.models.recordings.recording import Recording
from armtwin.scenarios.runner.job import Job
from armtwin.scenarios.runner.measure import recorded
from armtwin.scenarios.runner.stage import Tick
from armtwin.scenarios.scenario import ScenarioFile

Calibrate = Callable[[Recording, tuple[str, ...]], ArmCalibration]

METHODS: dict[str, Calibrate] = {"algorithm-1": algorithm_1.calibrate, "least-squares": least_squares.calibrate}


def methods_for(arm: Arm) -> dict[str, Calibrate]:
    """Return the methods by which `arm` can be calibrated: Algorithm 1 is for arms joined like the paper's."""
    return {name: method for name, method in METHODS.items() if name != "algorithm-1" or is_closed_form(arm)}


def calibrate_arm(job: Job, tick: Tick) -> dict[str, Any]:
    """Calibrate on every set of trajectories by both methods; the second one corrects the arm, as in the paper."""
    recording = recorded(job, "before")
    sets, methods = calibration_sets(job.scenario), methods_for(recording.arm)
    tables: dict[str, list[dict[str, Any]]] = {name: [] for name in methods}
    for number, trajectories in enumerate(sets):
        for name, calibrate in methods.items():
            found = calibrate(recording, trajectories)
            tables[name].append({"trajectories": trajectories, **found.as_table()})
        tick(number + 1, len(sets))
    return {"sets": sets, "methods": tables, "corrected_with": _correction(tables, sets)}


def calibration_sets(scenario: ScenarioFile) -> list[tuple[str, ...]]:
    """List the trajectories of each calibration: one at a time, then all at once."""
    single: list[tuple[str, ...]] = [(name,) for name in scenario.calibrate_on]
    return single if len(single) == 1 else [*single, scenario.calibrate_on]


def _correction(tables: dict[str, list[dict[str, Any]]], sets: list[tuple[str, ...]]) -> dict[str, Any]:
    """Choose what the arm is corrected with: least squares on the second trajectory, as the paper took its second."""
    number = min(1, len(sets) - 1)
    found = tables["least-squares"][number]
    return {
        "method": "least-squares",
        "calibration": number + 1,
        "lengths_mm": found["lengths_mm"],
        "joints_rad": found["joints_rad"],
    }
