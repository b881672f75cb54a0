"""A worker process: does one stage after the other as it is told, and reports how far it is.

Workers are spawned, not forked: a fork after an OpenGL context exists hangs. A worker whose parent was killed ends.
"""

from __future__ import annotations

import errno
import signal
import traceback
from collections.abc import Sequence
from multiprocessing.connection import Connection
from pathlib import Path

import cv2

from armtwin.models import atomic
from armtwin.models.errors import ArmtwinError
from armtwin.scenarios.processes import begin_worker
from armtwin.scenarios.runner.job import Job
from armtwin.scenarios.runner.stage import Tick, Work

_NO_ROOM = {errno.ENOSPC, errno.EDQUOT}


def serve(pipe: Connection, out: Path, effects: Sequence[Path] = ()) -> None:
    """Do the stages whose names and work come through `pipe` until it closes; `effects` are files of a person's own."""
    begin_worker(effects)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent hears Ctrl-C and ends its workers
    cv2.setNumThreads(1)
    job = Job(out)
    try:
        while True:
            name, work = pipe.recv()
            pipe.send(_do(job, name, work, lambda done, total: pipe.send(("tick", done, total))))
    except (EOFError, BrokenPipeError):
        return


def do_stage(job: Job, name: str, work: Work, tick: Tick) -> None:
    """Do one stage and write its file; what was half done before is done again."""
    job.save(name, work(job, tick))


def _do(job: Job, name: str, work: Work, tick: Tick) -> tuple[str, int, str]:
    try:
        do_stage(job, name, work, tick)
    except ArmtwinError as error:
        return ("failed", error.exit_code, str(error))
    except (EOFError, BrokenPipeError):
        raise
    except Exception as error:  # noqa: BLE001  # a defect of ours: told in one line, kept whole in a file
        if isinstance(error, OSError) and error.errno in _NO_ROOM:
            kept = "every finished stage is kept: make room, then run the same command again"
            return ("failed", 1, f"{job.out}: {error.strerror} in stage '{name}'; {kept}")
        log = job.out / "error.log"
        atomic.write_text(log, traceback.format_exc())
        return ("failed", 1, f"stage '{name}' broke down ({type(error).__name__}: {error}); {log} has the traceback")
    return ("done", 0, "")
