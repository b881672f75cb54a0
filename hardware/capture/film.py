"""A film of the moving arm as a recording: every picture, when it was taken, and the command that was in force.

Written aside and renamed when it is whole: a film that broke off shows a motion that nobody asked for.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from armtwin.hardware.capture.bench_record import write_bench_record
from armtwin.hardware.capture.pictures import pack, store
from armtwin.models import atomic
from armtwin.models.bench import BenchDescription, FilmingBench, Frame
from armtwin.models.errors import JobError
from armtwin.models.plan import Plan
from armtwin.models.recordings.recording import Recording, make_samples
from armtwin.models.recordings.writer import header_of, samples_csv

Array = NDArray[np.float64]


def film(
    bench: FilmingBench,
    plan: Plan,
    time_s: Array,
    folder: Path,
    held_out: tuple[str, ...] = (),
    report: Callable[[int, int], None] = lambda done, of: None,
) -> None:
    """Film a connected bench that follows a plan, its commands given at (N,) times, into `folder`.

    Its markers are empty: they are still to be measured. Raises `JobError` where the bench breaks off.
    """
    seen_s, given_s = np.empty(len(plan)), np.empty(len(plan))
    with atomic.folder_aside(folder) as aside:
        (aside / "frames").mkdir()
        camera = bench.description.camera
        with ThreadPoolExecutor(1) as writer:  # the arm does not wait for the disk
            stored = []
            for row, frame in enumerate(bench.film(time_s, plan.q_cmd)):
                stored.append(writer.submit(_keep, aside, row, frame, camera.image_width, camera.image_height))
                seen_s[row] = frame.time_s
                given_s[row] = frame.time_s if frame.commanded_s is None else frame.commanded_s
                report(row + 1, len(plan))
            for one in stored:
                one.result()
        if len(stored) < len(plan) or not (np.diff(seen_s) > 0).all():
            raise JobError(
                f"the film has {len(stored)} of {len(plan)} pictures, or two at once; film again, more slowly"
            )
        recording = _recording(bench.description, plan, seen_s, given_s, held_out)
        atomic.write_json(aside / "recording.json", header_in_motion(recording))
        atomic.write_text(aside / "samples.csv", samples_csv(recording))
        write_bench_record(aside / "bench.json", bench.description, bench.clock_origin_s)


def header_in_motion(recording: Recording) -> dict[str, Any]:
    """Return the content of `recording.json` of a moving recording."""
    header = header_of(recording)
    return {"schema": header.pop("schema"), "motion": "moving", **header}


def _keep(folder: Path, row: int, frame: Frame, width: int, height: int) -> None:
    path = folder / "frames" / f"{row:06d}.png"
    store(path, frame.image)
    pack(path, width, height)


def _recording(
    bench: BenchDescription, plan: Plan, seen_s: Array, given_s: Array, held_out: tuple[str, ...]
) -> Recording:
    return Recording(
        arm=bench.arm,
        camera=bench.camera,
        arm_plane_z_mm=bench.arm_plane_z_mm,
        sample=make_samples(len(plan)),
        time_s=np.round(seen_s, 6),
        commanded_s=np.round(given_s, 6),
        trajectory=plan.trajectory,
        q_cmd=plan.q_cmd,
        markers_px={name: np.full((len(plan), 2), np.nan) for name in bench.arm.marker_names},
        held_out=held_out,
    )
