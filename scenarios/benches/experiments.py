"""Experiments on a bench that stays open: each plan is captured into a folder of its own, measured, and appended."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from armtwin.calib.markers import measure_recording
from armtwin.hardware.capture.capture import run_capture
from armtwin.hardware.capture.folder import CaptureFolder
from armtwin.models.bench import Bench
from armtwin.models.errors import InputError
from armtwin.models.plan import Plan, steps_between
from armtwin.models.recordings.reader import read_recording
from armtwin.models.recordings.recording import Recording, make_samples
from armtwin.models.recordings.writer import arm_table, camera_table

Array = NDArray[np.float64]


def recorded_on(bench: Bench, plan: Plan, folder: Path, standing: Array | None = None) -> Recording:
    """Run a plan on a connected bench into `folder`, measured; the arm stands at `standing` (n,) rad, if it was moved.

    Raises `InputError` for a plan beyond the bench's limits or a folder that cannot be used, `JobError` where the bench
    fails, `RecordingError` where no marker is seen.
    """
    what = bench.description
    what.limits.check_plan(plan, folder.name)
    if standing is not None:
        for q in steps_between(standing, plan.q_cmd[0], what.limits.max_step_rad)[:-1]:
            bench.move(q)
    recording = CaptureFolder(folder, what, plan)
    recording.open(bench.clock_origin_s)
    try:
        run_capture(bench, recording)
        recording.finish(())
    finally:
        recording.close()
    return measure_recording(read_recording(folder, unmeasured=True))


def check_same_bench(bench: Bench, recording: Recording) -> None:
    """Raise `InputError` where a recording declares another arm, camera or plane than the bench has."""
    what = bench.description
    if recording.camera is None or not recording.markers_px:
        raise InputError("recording.json: key 'camera' is missing; the bench is watched by a camera")
    declared = {
        "arm": (arm_table(recording.arm), arm_table(what.arm)),
        "camera": (camera_table(recording.camera), camera_table(what.camera)),
        "arm_plane_z_mm": (recording.arm_plane_z_mm, what.arm_plane_z_mm),
    }
    for key, (recorded, here) in declared.items():
        if recorded != here:
            raise InputError(f"recording.json: key '{key}' is another one than the bench's; record on this bench first")


def followed_by(first: Recording, more: Recording) -> Recording:
    """Return a recording with another one's rows behind its own, on one clock that goes on."""
    # Where no trajectory is held out by name, a new one could be taken for the one to hold out.
    names = more.trajectory if first.held_out else np.full(len(more), first.trajectory[-1])
    apart = float(first.time_s[-1]) - min(0.0, float(_given(more)[0])) if first.has_time else 0.0
    both_given = first.commanded_s is not None or more.commanded_s is not None
    unseen = np.full((len(more), 2), np.nan)
    payload = [np.zeros(len(one)) if one.payload_kg is None else one.payload_kg for one in (first, more)]
    return replace(
        first,
        sample=np.concatenate([first.sample, first.sample[-1] + 1 + make_samples(len(more))]),
        time_s=np.concatenate([first.time_s, more.time_s + apart]) if first.has_time else _unknown(first, more),
        commanded_s=np.concatenate([_given(first), _given(more) + apart]) if first.has_time and both_given else None,
        trajectory=np.concatenate([first.trajectory, names]),
        q_cmd=np.concatenate([first.q_cmd, more.q_cmd]),
        markers_px={
            name: np.concatenate([old, more.markers_px.get(name, unseen)]) for name, old in first.markers_px.items()
        },
        q_meas=None,
        payload_kg=np.concatenate(payload) if any(part.any() for part in payload) else None,
        temperature_c=None,
        folder=None,
    )


def _given(recording: Recording) -> Array:
    return np.full(len(recording), np.nan) if recording.commanded_s is None else recording.commanded_s


def _unknown(first: Recording, more: Recording) -> Array:
    return np.full(len(first) + len(more), np.nan)
