"""A recording that grows row by row: each pose is on disk before the arm moves on, and a broken-off one is taken up.

recording.json     written first, whole
bench.json         what the commands became on this bench, and when its clock began: no part of the recording, but it is
                   taken up on the same only
frames/000007.png  the picture of a pose, flushed to disk; packed when all are there
samples.csv        its row, appended and flushed after the picture: a row stands for a finished pose
"""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext, suppress
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from armtwin.hardware.capture.bench_record import (
    agreed_hold_out,
    clocks_apart_s,
    first_difference,
    note_hold_out,
    read_json,
    refuse_other_actuation,
    write_bench_record,
)
from armtwin.hardware.capture.pictures import bytes_stored, pack, store
from armtwin.hardware.capture.rows import Row, cells_of, line_of, read_time_s, whole_rows
from armtwin.models import atomic
from armtwin.models.bench import BenchDescription, Frame
from armtwin.models.errors import InputError, JobError, RecordingError
from armtwin.models.folder_lock import hold_folder, only_writer
from armtwin.models.plan import Plan
from armtwin.models.recordings.recording import Recording
from armtwin.models.recordings.writer import columns_of, header_of, row_of

Array = NDArray[np.float64]

# A folder in which a file or two of the system stand is still empty for a recording.
_IGNORED = {".DS_Store", "lost+found"}


class CaptureFolder:
    """The recording folder of one plan on one arm; `open` it before anything moves."""

    def __init__(
        self, folder: Path, bench: BenchDescription, plan: Plan, hold_out: tuple[str, ...] | None = None
    ) -> None:
        """Note what is to be captured; `hold_out` are trajectories to be held out, None: what it began with."""
        self.folder = folder
        self.plan = plan
        self._bench = bench
        self._arm, self._camera, self._arm_plane_z_mm = bench.arm, bench.camera, bench.arm_plane_z_mm
        self._hold_out = hold_out
        self._last_s = 0.0
        self._done = 0
        self._time_offset_s = 0.0
        self._handle: int | None = None
        self._lock: int | None = None

    @property
    def done(self) -> int:
        """How many poses of the plan are on disk."""
        return self._done

    def check(self) -> None:
        """Count the poses that are on disk, and write nothing.

        Raises `InputError` if the folder holds something else: another arm's or camera's data, another plan's poses,
        what was captured on a bench that makes other things of commands, no recording at all; if another capture is at
        work in it; or if the disk has no room for the pictures that are missing.
        """
        with self._refusing(), only_writer(self.folder) if self.folder.is_dir() else nullcontext():
            self._look()

    def open(self, clock_origin_s: float | None = None) -> None:
        """Begin the recording, or take up the one that is there; raises as `check` does.

        `clock_origin_s` is the Unix time from which the bench's frames count theirs. A recording that is taken up goes
        on with the first clock, or where that is not known, from its last pose.
        """
        self.check()
        with self._refusing():
            self.folder.mkdir(parents=True, exist_ok=True)
            self._lock = hold_folder(self.folder)
            try:
                self._begin(self._look(), clock_origin_s)
            except BaseException:
                self.close()
                raise

    def add(self, frame: Frame) -> None:
        """Put the picture and the row of the next pose on disk; raises `JobError` if they do not fit.

        What was begun is taken back then, so that the recording stays whole.
        """
        if self._handle is None:
            raise JobError(f"{self.folder}: not open")
        row = self._row(self._done, frame)
        whole = os.fstat(self._handle).st_size
        try:
            store(self.frame_path(self._done), frame.image)
            _append(self._handle, row)
        except OSError as error:
            os.ftruncate(self._handle, whole)
            raise JobError(
                f"{self.folder}: cannot be written ({error.strerror}); {self._done} of {len(self.plan)} poses are "
                "kept: make room, then run the same command again"
            ) from None
        self._done += 1

    def finish(self, held_out: tuple[str, ...] = ()) -> None:
        """Note the trajectories to be kept for validation, now that all their rows are there, and pack the pictures.

        These are what was asked for when the capture began, or `held_out` where nothing was.
        """
        held_out = held_out if self._hold_out is None else self._hold_out
        path = self.folder / "recording.json"
        header = json.loads(path.read_text("utf-8"))
        if held_out and header.get("held_out") != list(held_out):  # what was measured since stays in the file
            atomic.write_json(path, {**header, "held_out": list(held_out)})
        with suppress(OSError):  # they are as good unpacked
            for sample in range(self._done):
                pack(self.frame_path(sample), self._camera.image_width, self._camera.image_height)

    def close(self) -> None:
        """Close the file of rows and let others have the folder. May be called twice."""
        for handle in (self._handle, self._lock):
            if handle is not None:
                os.close(handle)
        self._handle = self._lock = None

    def frame_path(self, sample: int) -> Path:
        """Where the picture of a pose stands."""
        return self.folder / "frames" / f"{sample:06d}.png"

    @contextmanager
    def _refusing(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            raise InputError(f"{self.folder}: cannot be written ({error.strerror}); choose another folder") from None

    def _look(self) -> int:
        """Return how many bytes of rows are to be kept; refuse what is not this plan's recording."""
        there = set(self.folder.iterdir()) - set(atomic.leftovers(self.folder)) if self.folder.is_dir() else set()
        found = {path.name for path in there} - _IGNORED
        if found and "recording.json" not in found:
            raise InputError(
                f"{self.folder}: not empty and no recording (found {sorted(found)[0]}); choose another --out"
            )
        if found:
            self._refuse_other_bench()
        frames = self.folder / "frames"
        if frames.exists() and not frames.is_dir():
            raise RecordingError(
                f"{frames}: is a file, the folder of the pictures is wanted there; choose another --out"
            )
        self._refuse_full_disk()
        samples = self.folder / "samples.csv"
        return self._take_up(samples) if samples.exists() else 0

    def _begin(self, kept: int, clock_origin_s: float | None) -> None:
        """Make the folder ready for the next row behind the bytes that are kept."""
        atomic.clear_leftovers(self.folder)
        if not (self.folder / "recording.json").exists():
            atomic.write_json(self.folder / "recording.json", self._header())
        if not self._done:
            write_bench_record(self._bench_file, self._bench, clock_origin_s)
        else:
            self._time_offset_s = clocks_apart_s(self._bench_file, clock_origin_s, self._last_s)
        if self._hold_out is not None:
            note_hold_out(self._bench_file, self._hold_out)
        (self.folder / "frames").mkdir(exist_ok=True)
        samples = self.folder / "samples.csv"
        self._handle = os.open(samples, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o644)
        os.ftruncate(self._handle, kept)
        if not kept:
            _append(self._handle, line_of(self._columns()))
        atomic.sync_folder(self.folder)
        atomic.sync_folder(self.folder.absolute().parent)

    def _take_up(self, samples: Path) -> int:
        """Count the finished rows, check them against the plan, and return how many bytes they are."""
        lines = whole_rows(samples)
        if not lines:
            return 0
        header, *rows = lines
        if header.cells != self._columns():
            raise RecordingError(f"{samples}: its columns are not those of this plan's capture; choose another --out")
        while rows and self._lacks_its_picture(len(rows) - 1, rows[-1]):
            rows.pop()
        times = [self._checked_time(samples, sample, row.cells) for sample, row in enumerate(rows)]
        if rows:
            refuse_other_actuation(self._bench_file, self._bench)
            self._hold_out = agreed_hold_out(self._bench_file, self._hold_out)
        self._done = len(rows)
        self._last_s = next((time_s for time_s in reversed(times) if time_s is not None), 0.0)
        return [header, *rows][-1].end

    def _lacks_its_picture(self, sample: int, row: Row) -> bool:
        """Whether a row is as a capture writes it, but its picture never reached the disk: it is done again."""
        if sample >= len(self.plan) or self._has_picture(sample):
            return False
        commanded = self._columns().index("commanded_s")
        found, wanted = (
            [*cells[2:commanded], *cells[commanded + 1 :]] for cells in (row.cells, cells_of(self._row(sample)))
        )
        return found == wanted  # a measured one is no capture's to drop

    def _has_picture(self, sample: int) -> bool:
        path = self.frame_path(sample)
        return path.is_file() and path.stat().st_size > 0

    def _checked_time(self, samples: Path, sample: int, cells: list[str]) -> float | None:
        """Return when a row was taken; raises `RecordingError` if it is not this plan's, or lacks its picture."""
        where = f"{samples}: line {sample + 2}"
        if sample >= len(self.plan):
            raise RecordingError(f"{where}: the plan has {len(self.plan)} poses only; choose another --out")
        wanted = cells_of(self._row(sample))
        keys = [0, *range(2, 3 + self._arm.n_joints)]  # sample, trajectory and commands; time and markers are free
        if len(cells) != len(wanted) or [cells[k] for k in keys] != [wanted[k] for k in keys]:
            raise RecordingError(
                f"{where}: holds pose '{','.join(cells[2 : 3 + self._arm.n_joints])[:80]}' of another plan, "
                f"this one has '{','.join(wanted[2 : 3 + self._arm.n_joints])[:80]}'; choose another --out"
            )
        if not self._has_picture(sample):
            raise RecordingError(f"{where}: its picture frames/{sample:06d}.png is missing; choose another --out")
        return read_time_s(cells[1], where)

    def _refuse_other_bench(self) -> None:
        path = self.folder / "recording.json"
        found = read_json(path)
        if not isinstance(found, dict):
            raise RecordingError(f"{path}: no recording, a table in braces is wanted; choose another --out")
        wanted: dict[str, Any] = json.loads(json.dumps(self._header()))
        for key in ("schema", "arm", "camera", "arm_plane_z_mm"):
            here = found.get(key)
            if here != wanted[key]:
                what = "another arm's data" if key == "arm" else f"data with another {key}"
                raise RecordingError(
                    f"{path}: holds {what} ({first_difference(key, here, wanted[key])}); choose another --out"
                )

    def _refuse_full_disk(self) -> None:
        existing = next(path for path in (self.folder, *self.folder.absolute().parents) if path.exists())
        missing = len(self.plan) - len(list((self.folder / "frames").glob("*.png")))
        wanted = missing * bytes_stored(self._camera.image_width, self._camera.image_height)
        free = shutil.disk_usage(existing).free
        if wanted > free:
            raise InputError(
                f"{self.folder}: {missing} pictures may need {wanted / 1e6:.0f} MB, the disk has {free / 1e6:.0f} MB "
                "free; make room or choose another --out"
            )

    @property
    def _bench_file(self) -> Path:
        return self.folder / "bench.json"

    def _header(self) -> dict[str, Any]:
        return header_of(self._recording(0))

    def _columns(self) -> list[str]:
        return columns_of(self._recording(0))

    def _row(self, sample: int, frame: Frame | None = None) -> bytes:
        return line_of(row_of(self._recording(sample, frame), 0))

    def _recording(self, sample: int, frame: Frame | None = None) -> Recording:
        """One row as a recording; its markers are not measured yet, which an empty cell says."""
        rows = slice(sample, sample + 1)
        seen_s = 0.0 if frame is None else frame.time_s + self._time_offset_s
        given_s = np.nan if frame is None or frame.commanded_s is None else frame.commanded_s + self._time_offset_s
        return Recording(
            arm=self._arm,
            camera=self._camera,
            arm_plane_z_mm=self._arm_plane_z_mm,
            sample=np.array([sample]),
            time_s=np.array([round(seen_s, 6)]),
            commanded_s=np.array([round(given_s, 6)]),
            trajectory=self.plan.trajectory[rows],
            q_cmd=self.plan.q_cmd[rows],
            markers_px={name: np.full((1, 2), np.nan) for name in self._arm.marker_names},
            payload_kg=self.plan.payload_kg[rows] if self.plan.payload_kg.any() else None,
        )


def _append(handle: int, data: bytes) -> None:
    """Write all of `data` at the end and flush it to disk; raises OSError."""
    view = memoryview(data)
    while view:
        view = view[os.write(handle, view) :]
    os.fsync(handle)
