"""The paper's whole experiment on the emulated bench gives the calibration that the simulated bench gives."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from armtwin.calib.arm.least_squares import ArmCalibration, calibrate
from armtwin.calib.markers import measure_recording
from armtwin.hardware.bench.bench_file import BenchSetup, read_bench
from armtwin.hardware.bench.hardware_bench import HardwareBench
from armtwin.hardware.capture.capture import run_capture
from armtwin.hardware.capture.folder import CaptureFolder
from armtwin.hardware.emulator import missing_packages
from armtwin.hardware.link.messages import TICKS_PER_US
from armtwin.models.bench import Bench
from armtwin.models.plan import Plan, paper_plan
from armtwin.models.recordings.reader import read_recording
from armtwin.models.recordings.recording import Recording
from armtwin.scenarios.emulated_bench import EmulatedBench, paper_world
from armtwin.scenarios.marker_finder import marker_finder
from armtwin.sim.bench import SimulatedBench

pytestmark = [
    pytest.mark.avr,
    pytest.mark.slow,
    pytest.mark.skipif(bool(missing_packages()), reason=missing_packages() or "present"),
]

CIRCLES = ("circle_15", "circle_25")


def test_same_calibration_within_two_standard_deviations(tmp_path: Path) -> None:
    with EmulatedBench() as emulated:
        setup = read_bench(emulated.bench_file)
        plan = paper_plan(setup.arm)
        with HardwareBench(setup, marker_finder(setup.arm, setup.camera, setup.arm_plane_z_mm)) as bench:
            captured = measured(bench, setup, plan, tmp_path / "emulated")
    # Commands reach a servo in steps of 0.5 us, twenty times what the pictures resolve. So both arms are told, and
    # calibrated with, the angles that can be sent; the standard deviations are then those of the pictures' noise.
    sent = replace(plan, q_cmd=as_sent(setup, plan.q_cmd))
    simulator = SimulatedBench(paper_world(), seed=1, shadows=False)
    simulator.connect()
    simulated = measured(simulator, setup, sent, tmp_path / "simulated")
    simulator.close()

    distance = in_standard_deviations(calibrated(replace(captured, q_cmd=sent.q_cmd)), calibrated(simulated))

    assert distance < 2.0


def in_standard_deviations(one: ArmCalibration, other: ArmCalibration) -> float:
    """Mahalanobis distance of two calibrations to each dimension that can be known (the gauge leaves one out)."""
    difference = one.values - other.values
    variances, axes = np.linalg.eigh(one.covariance + other.covariance)
    known = variances > 1e-9 * variances.max()
    z = (axes.T @ difference)[known] / np.sqrt(variances[known])
    return float(np.sqrt(np.mean(z**2)))


def measured(bench: Bench, setup: BenchSetup, plan: Plan, folder: Path) -> Recording:
    recording = CaptureFolder(folder, setup.description, plan)
    recording.open()
    run_capture(bench, recording)
    recording.close()
    return measure_recording(read_recording(folder))


def as_sent(setup: BenchSetup, q_cmd: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return commands rounded to what a timer of the firmware can hold."""
    ticks = np.round(setup.servo_map.pulses_us(q_cmd) * TICKS_PER_US)
    return setup.servo_map.angles_rad(ticks / TICKS_PER_US)


def calibrated(recording: Recording) -> ArmCalibration:
    calibration = calibrate(recording, CIRCLES)
    assert not calibration.outliers
    return calibration
