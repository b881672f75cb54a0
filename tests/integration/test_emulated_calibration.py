"""The emulated bench gives the calibration that the simulated one gives, from the same commands in the same world."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from calib.arm.least_squares import calibrate
from calib.markers import measure_recording
from hardware.bench_file import read_bench
from hardware.capture import run_capture
from hardware.capture_folder import CaptureFolder
from hardware.emulator import missing_packages
from hardware.hardware_bench import HardwareBench
from hardware.messages import TICKS_PER_US
from models.plan import Plan, paper_plan
from models.recording_reader import read_recording
from scenarios.emulated_bench import EmulatedBench, paper_world
from scenarios.marker_finder import marker_finder
from sim.observe import make_recording

pytestmark = [
    pytest.mark.avr,
    pytest.mark.slow,
    pytest.mark.skipif(bool(missing_packages()), reason=missing_packages() or "present"),
]

# Every fifth pose of the two circles; ARMTWIN_WHOLE_PAPER=1 runs every pose of all three trajectories.
STRIDE = 1 if os.environ.get("ARMTWIN_WHOLE_PAPER") else 5
CIRCLES = ("circle_15", "circle_25")


def test_same_calibration_within_two_standard_deviations(tmp_path: Path):
    with EmulatedBench() as emulated:
        setup = read_bench(emulated.bench_file)
        whole = paper_plan(setup.arm)
        rows = np.arange(0, len(whole) if STRIDE == 1 else 100, STRIDE)
        plan = Plan(whole.trajectory[rows], whole.q_cmd[rows], whole.payload_kg[rows])
        recording = CaptureFolder(tmp_path / "recording", setup.arm, setup.camera, setup.arm_plane_z_mm, plan)
        recording.open()
        with HardwareBench(setup, marker_finder(setup.arm, setup.camera, setup.arm_plane_z_mm)) as bench:
            run_capture(bench, recording)
        recording.close()
    captured = measure_recording(read_recording(tmp_path / "recording"))
    noise_px = captured.pixel_noise_px
    assert noise_px is not None

    # Commands reach a servo in steps of 0.5 us. On the whole plan these do not average out: they turn joint 1 by 2.5
    # standard deviations, 0.004 deg. So the simulated servos are told the same.
    pulses_us = np.round(setup.servo_map.pulses_us(captured.q_cmd) * TICKS_PER_US) / TICKS_PER_US
    q_sent = setup.servo_map.angles_rad(pulses_us)
    simulated = make_recording(paper_world(), q_sent, captured.trajectory, None, np.random.default_rng(0), noise_px)
    simulated = replace(simulated, q_cmd=captured.q_cmd)
    ours, theirs = calibrate(captured, CIRCLES), calibrate(simulated, CIRCLES)

    assert ours.names == theirs.names
    assert not ours.outliers
    variance = np.diag(ours.covariance) + np.diag(theirs.covariance)
    np.testing.assert_array_less(np.abs(ours.values - theirs.values), 2.0 * np.sqrt(variance))
