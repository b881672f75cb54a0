"""Long work beside the bench: calibrations and diagnoses, each in a process of its own, with what it is doing now."""

from __future__ import annotations

import multiprocessing
import multiprocessing.process
import shutil
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, Literal

from armtwin.models.errors import ArmtwinError, JobError
from armtwin.scenarios.processes import end_with_parent

Kind = Literal["calibrate", "diagnose"]
State = Literal["running", "done", "failed", "stopped"]
# One at a time: two would starve the bench on two cores.
_MOST_KEPT = 50


@dataclass(eq=False)
class Job:
    """A piece of work: `said` is what it is doing or what became of it, `results` the names of the files it wrote."""

    number: int
    kind: Kind
    folder: Path
    state: State = "running"
    said: str = "starting"
    headline: str = ""
    started_s: float = field(default_factory=time.monotonic)
    seconds: float = 0.0
    results: tuple[str, ...] = ()
    process: multiprocessing.process.BaseProcess | None = None


class Jobs:
    """Runs jobs on copies of a recording; `when_done` hears of each that ended well, from a thread of its own.

    Where several have their jobs on one machine, `slots` says how many may run at a time in all.
    """

    def __init__(
        self, folder: Path, when_done: Callable[[Job], None], slots: threading.BoundedSemaphore | None = None
    ) -> None:
        self._slots = slots or threading.BoundedSemaphore(1)
        self._folder = folder
        self._when_done = when_done
        self._jobs: dict[int, Job] = {}
        self._lock = threading.Lock()

    def start(self, kind: Kind, recording: Path) -> Job:
        """Begin a job on the recording as it is now; raises `JobError` while another one runs."""
        with self._lock:
            if any(job.state == "running" for job in self._jobs.values()):
                raise JobError("a calibration or diagnosis is running; wait for it, or stop it")
            number = len(self._jobs) + 1
            if number > _MOST_KEPT:
                raise JobError(f"{_MOST_KEPT} jobs were run in this visit; start the server again")
            if not self._slots.acquire(blocking=False):
                raise JobError("others' calibrations and diagnoses are running; try again in a moment")
            folder = self._folder / f"{kind}-{number:03d}"
            copy = folder / "recording"
            copy.mkdir(parents=True, exist_ok=True)
            for name in ("recording.json", "samples.csv"):
                shutil.copyfile(recording / name, copy / name)
            job = self._jobs[number] = Job(number, kind, folder)
        ours, theirs = multiprocessing.get_context("spawn").Pipe(duplex=False)
        job.process = multiprocessing.get_context("spawn").Process(
            target=_work, args=(theirs, kind, str(copy), str(folder)), name=f"{kind}-{number}", daemon=True
        )
        job.process.start()
        theirs.close()
        threading.Thread(target=self._listen, args=(job, ours), name=f"job-{number}", daemon=True).start()
        return job

    def get(self, number: int) -> Job:
        """Return a job; raises `JobError` for a number that there is not."""
        if number not in self._jobs:
            raise JobError(f"there is no job {number}")
        return self._jobs[number]

    def all(self) -> list[Job]:
        """Return every job, oldest first."""
        return list(self._jobs.values())

    def stop(self, number: int) -> None:
        """End a job that runs."""
        job = self.get(number)
        if job.process is not None and job.state == "running":
            job.state, job.said = "stopped", "stopped"
            job.process.kill()

    def close(self) -> None:
        """End whatever runs."""
        for number in list(self._jobs):
            self.stop(number)

    def _listen(self, job: Job, pipe: Connection) -> None:
        outcome: dict[str, Any] | None = None
        try:
            while outcome is None:
                kind, said = pipe.recv()
                if kind == "tell":
                    job.said = said
                else:
                    outcome = said
        except EOFError:
            outcome = {"state": "failed", "said": "its process ended; the server's terminal may say why"}
        self._slots.release()
        job.seconds = time.monotonic() - job.started_s
        if job.state == "stopped":
            return
        job.results = tuple(sorted(path.name for path in job.folder.iterdir() if path.is_file()))
        job.headline = outcome.get("headline", "")
        job.said = outcome["said"]
        if outcome["state"] == "done":
            self._when_done(job)
        job.state = outcome["state"]


def _work(pipe: Connection, kind: Kind, recording: str, out: str) -> None:
    """Do a job and send what is done: the body of its process."""
    end_with_parent()

    def tell(what: str) -> None:
        pipe.send(("tell", what))

    try:
        headline = {"calibrate": _calibrate, "diagnose": _diagnose}[kind](Path(recording), Path(out), tell)
        pipe.send(("end", {"state": "done", "said": "done", "headline": headline}))
    except ArmtwinError as error:
        pipe.send(("end", {"state": "failed", "said": str(error)}))


def _calibrate(recording: Path, out: Path, tell: Callable[[str], None]) -> str:
    from armtwin.calib.arm.least_squares import calibrate
    from armtwin.models.recordings.reader import read_recording
    from armtwin.models.twin import Twin, write_twin

    tell("fitting link lengths and joint zeros")
    data = read_recording(recording)
    found = calibrate(data)
    base = found.base_in_board_mm
    if base is None:
        raise JobError("no marker was seen, so nothing can be said of where the arm stands")
    twin = Twin(data.arm, found.deviation, base, data.camera, ())
    write_twin(out / "twin.toml", twin, "Calibrated by least squares on a served bench.")
    return f"{found.n_poses} poses, {found.rms_px:.3g} px left"


def _diagnose(recording: Path, out: Path, tell: Callable[[str], None]) -> str:
    from armtwin.models.recordings.reader import read_recording
    from armtwin.scenarios.diagnosis.pipeline import report_on, write_report
    from armtwin.scenarios.diagnosis.words import headline

    report = report_on(read_recording(recording), tell)
    tell("writing the report")
    write_report(out, "the served bench's recording", report)
    return f"{report.diagnosis.verdict.upper()}: {headline(report.diagnosis)}"
