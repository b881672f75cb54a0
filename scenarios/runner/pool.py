"""Worker processes of a run, each busy with at most one stage.

Not `concurrent.futures`: when a worker is killed its pool knows only that one was, not which stage it did, and ends no
worker that is in the middle of a stage, which Ctrl-C and a stage that failed have to.
"""

from __future__ import annotations

import multiprocessing
from collections.abc import Iterator
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess

from armtwin.models.catalogue.registry import registered_files
from armtwin.models.errors import JobError
from armtwin.scenarios.processes import one_thread_each
from armtwin.scenarios.runner.job import Job
from armtwin.scenarios.runner.stage import Work
from armtwin.scenarios.runner.worker import serve

# ("tick", done, total), ("done", 0, "") or ("failed", exit code, what went wrong).
Message = tuple[str, int, int | str]


class WorkerPool:
    """Up to `size` workers on one job; they are ended when its block is left."""

    def __init__(self, job: Job, size: int) -> None:
        self._job = job
        self._size = size
        self._pipes: dict[Connection, BaseProcess] = {}
        self._stages: dict[Connection, str] = {}

    def __enter__(self) -> WorkerPool:
        return self

    def __exit__(self, *_: object) -> None:
        for pipe, process in self._pipes.items():
            pipe.close()
            if self._stages:
                process.terminate()
        for process in self._pipes.values():
            process.join()

    @property
    def busy(self) -> set[str]:
        """Stages that are being done."""
        return set(self._stages.values())

    @property
    def free(self) -> bool:
        """Whether a worker has nothing to do, or may still be started."""
        return len(self._stages) < self._size

    def start(self, name: str, work: Work) -> None:
        """Give a stage to a free worker."""
        pipe = next((pipe for pipe in self._pipes if pipe not in self._stages), None) or self._spawn()
        self._stages[pipe] = name
        pipe.send((name, work))

    def messages(self) -> Iterator[tuple[str, Message]]:
        """Wait for reports and yield each with its stage."""
        for pipe in wait(list(self._stages)):
            assert isinstance(pipe, Connection)
            name = self._stages[pipe]
            try:
                message = pipe.recv()
            except EOFError:
                raise JobError(f"the process that did stage '{name}' was ended; run the same command again") from None
            if message[0] != "tick":
                del self._stages[pipe]
            yield name, message

    def _spawn(self) -> Connection:
        context = multiprocessing.get_context("spawn")
        here, there = context.Pipe()
        process = context.Process(target=serve, args=(there, self._job.out, registered_files()), daemon=True)
        with one_thread_each():
            process.start()
        there.close()
        self._pipes[here] = process
        return here
