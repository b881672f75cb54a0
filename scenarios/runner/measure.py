"""Stages that turn frames into pixels, with the default detector and with the paper's."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from armtwin.calib.markers import MarkerReading, measure_frames, with_markers
from armtwin.models.errors import RecordingError
from armtwin.models.recordings.reader import read_recording
from armtwin.models.recordings.recording import Recording, make_samples
from armtwin.models.recordings.writer import write_recording
from armtwin.scenarios.runner.camera import calibrated_camera
from armtwin.scenarios.runner.capture import samples_before
from armtwin.scenarios.runner.job import Job
from armtwin.scenarios.runner.picture import generator
from armtwin.scenarios.runner.stage import Tick
from armtwin.scenarios.runner.world import build_world, declared_arm
from armtwin.scenarios.scenario import ScenarioFile


def measure_before(job: Job, tick: Tick) -> dict[str, Any]:
    """Measure the markers in the frames taken before the arm was calibrated."""
    return _measure(job, "before", (job.scenario.validate_on,), tick)


def measure_after(job: Job, tick: Tick) -> dict[str, Any]:
    """Measure the markers in the frames taken after the arm was calibrated."""
    return _measure(job, "after", (), tick)


def measure_extended(job: Job, tick: Tick) -> dict[str, Any]:
    """Measure the markers in the frames taken with the commands of the extended twin."""
    return _measure(job, "extended", (), tick)


def recorded(job: Job, recording: str) -> Recording:
    """Return a recording of this run, measured by the default detector."""
    return read_recording(job.recordings / recording)


def _measure(job: Job, name: str, held_out: tuple[str, ...], tick: Tick) -> dict[str, Any]:
    """Complete `recordings/<name>` with the default detector's pixels; return what both detectors found."""
    taken = job.load(f"capture_{name}")
    n = len(taken["trajectory"])
    frames = Recording(
        arm=declared_arm(job.scenario),
        camera=calibrated_camera(job),
        arm_plane_z_mm=job.scenario.bench.arm_plane_z_mm,
        sample=make_samples(n),
        time_s=np.array(taken["time_s"]),
        commanded_s=np.array(taken["commanded_s"]),
        trajectory=np.array(taken["trajectory"], dtype=np.str_),
        q_cmd=np.array(taken["q_cmd_rad"]),
        held_out=held_out,
        folder=job.recordings / name,
    )
    fine = measure_frames(frames, "subpixel", progress=lambda done, _: tick(done, 2 * n))
    coarse = _by_paper(frames, lambda done, _: tick(n + done, 2 * n))
    measured = with_faults(job.scenario, name, with_markers(frames, fine))
    # A centre is known no better than the camera that it is compared through, and that fits its board to so much.
    detection, camera = measured.pixel_noise_px or 0.0, float(job.load("camera")["rms_px"])
    write_recording(job.recordings / name, replace(measured, pixel_noise_px=float(np.hypot(detection, camera))))
    return {"subpixel": _table(frames, fine), "paper": coarse}


def with_faults(scenario: ScenarioFile, name: str, measured: Recording) -> Recording:
    """Let happen to recording `name` what no picture shows: markers that detection mistakes for something else."""
    rng = generator(scenario, f"detection of {name}")
    markers = measured.markers_px
    for detection in build_world(scenario, samples_before(scenario, name)).detections:
        markers = detection(markers, rng)
    return replace(measured, markers_px=markers)


def _by_paper(frames: Recording, progress: Callable[[int, int], None]) -> dict[str, Any]:
    """Measure by the paper's chain, for comparison only: where it finds nothing at all, the run goes on."""
    try:
        return _table(frames, measure_frames(frames, "paper", progress=progress))
    except RecordingError as error:
        names = frames.arm.marker_names
        nothing = [[None, None]] * len(frames)
        return {
            "markers_px": dict.fromkeys(names, nothing),
            "unseen": dict.fromkeys(names, len(frames)),
            "messages": [str(error)],
        }


def _table(frames: Recording, readings: tuple[MarkerReading, ...]) -> dict[str, Any]:
    names = frames.arm.marker_names
    return {
        "markers_px": {name: [reading.pixels[name] for reading in readings] for name in names},
        "unseen": {name: sum(name not in reading.discs for reading in readings) for name in names},
        "messages": [f"sample {row}: {line}" for row, reading in enumerate(readings) for line in reading.messages],
    }
