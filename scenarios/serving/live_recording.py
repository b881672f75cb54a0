"""A recording that grows while somebody plays: each pose is on disk before the one after the next is taken."""

from __future__ import annotations

import csv
import io
import os
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path

import numpy as np

from armtwin.models import atomic
from armtwin.models.errors import JobError
from armtwin.models.recordings.recording import Recording
from armtwin.models.recordings.writer import columns_of, header_of, row_of
from armtwin.scenarios.serving.shot import Shot
from armtwin.scenarios.serving.sources import BenchSource


class LiveRecording:
    """A recording folder (`armtwin.recording/1`) to which poses are added one by one; make it by `new_recording`.

    `n` poses are in it already, the last seen at `last_s`. A bench that is opened anew starts its clock anew; in the
    recording time goes on.
    """

    def __init__(self, folder: Path, source: BenchSource, n: int = 0, last_s: float = 0.0) -> None:
        self.folder = folder
        self._source = source
        self._n = n
        self._last_s, self._apart_s, self._clock_s = last_s, 0.0, np.inf if n else -np.inf
        # Packing a picture takes as long as taking one: it is done while the arm moves on.
        self._writer = ThreadPoolExecutor(1, thread_name_prefix="recording")
        self._last: Future[None] | None = None

    def __len__(self) -> int:
        return self._n

    def add(self, shot: Shot, trajectory: str, payload_kg: float) -> None:
        """Put a picture and its row on disk, once those of the pose before are there; raises what befell these."""
        self.wait()
        self._last = self._writer.submit(self._write, self._n, shot, self._row(shot, trajectory, payload_kg))
        self._n += 1

    def wait(self) -> None:
        """Return when all is on disk; raises `JobError` where the last pose is lost, since it could not be written."""
        last, self._last = self._last, None
        if last is None:
            return
        try:
            last.result()
        except OSError as error:
            self._n -= 1
            name = self.folder.name
            raise JobError(
                f"{name}: the last pose is not kept, it cannot be written ({error.strerror}); make room, then go on"
            ) from None

    def close(self) -> None:
        """Wait for what is being written, and write no more."""
        self._writer.shutdown(wait=True)

    def _write(self, number: int, shot: Shot, one: Recording) -> None:
        """Write picture, then row: a row stands for a picture that is there."""
        atomic.write_bytes(self.folder / "frames" / f"{number:06d}.png", shot.png)
        path = self.folder / "samples.csv"
        if not number:
            atomic.write_json(self.folder / "recording.json", header_of(one))
            atomic.write_text(path, _csv(columns_of(one)) + _csv(row_of(one, 0)))
        else:
            _append(path, _csv(row_of(one, 0)))

    def _row(self, shot: Shot, trajectory: str, payload_kg: float) -> Recording:
        source, unseen = self._source, np.full(2, np.nan)
        given_s, seen_s = shot.frame.commanded_s, shot.frame.time_s
        if seen_s < self._clock_s:  # its clock was started anew
            self._apart_s = self._last_s - (seen_s if given_s is None else min(given_s, seen_s))
        self._clock_s, self._last_s = seen_s, seen_s + self._apart_s
        return Recording(
            arm=source.description.arm,
            camera=source.description.camera,
            arm_plane_z_mm=source.description.arm_plane_z_mm,
            sample=np.array([self._n]),
            time_s=np.array([round(self._last_s, 6)]),
            commanded_s=np.array([np.nan if given_s is None else round(given_s + self._apart_s, 6)]),
            trajectory=np.array([trajectory]),
            q_cmd=shot.q_cmd[None],
            markers_px={name: shot.measured_px.get(name, unseen)[None] for name in source.description.arm.marker_names},
            payload_kg=np.array([payload_kg]),
        )


def last_recording(parent: Path, source: BenchSource) -> LiveRecording | None:
    """Return the newest recording below `parent` to go on with, a row that was left half written cut off; or None."""
    folders = sorted(path.parent for path in parent.glob("recording-*/samples.csv"))
    if not folders:
        return None
    path = folders[-1] / "samples.csv"
    whole = path.read_bytes().rpartition(b"\n")[0] + b"\n"
    atomic.write_bytes(path, whole)
    rows = list(csv.DictReader(io.StringIO(whole.decode())))
    return LiveRecording(folders[-1], source, len(rows), float(rows[-1]["time_s"])) if rows else None


def new_recording(parent: Path, source: BenchSource) -> LiveRecording:
    """Return an empty recording in a new folder below `parent`: recording-001, recording-002 ..."""
    parent.mkdir(parents=True, exist_ok=True)
    for number in range(1, 100_000):
        folder = parent / f"recording-{number:03d}"
        try:
            folder.mkdir()
        except FileExistsError:
            continue
        return LiveRecording(folder, source)
    raise OSError(f"{parent}: too many recordings")


def _append(path: Path, row: str) -> None:
    """Append a row to the disk, all of it or nothing."""
    before = path.stat().st_size
    try:
        with path.open("a", encoding="utf-8", newline="") as stream:
            stream.write(row)
            stream.flush()
            os.fsync(stream.fileno())
    except OSError:
        os.truncate(path, before)
        raise


def _csv(cells: list[str]) -> str:
    out = io.StringIO()
    csv.writer(out, lineterminator="\n").writerow(cells)
    return out.getvalue()
