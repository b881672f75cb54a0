"""Run the stages that are not done yet, two at a time where they do not wait for each other."""

from __future__ import annotations

import multiprocessing
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TaskID, TextColumn, TimeElapsedColumn

from armtwin.models.errors import InputError, JobError
from armtwin.scenarios.runner.job import Job
from armtwin.scenarios.runner.progress import Work
from armtwin.scenarios.runner.worker import serve

# One thread a worker: results then do not depend on how sums are split over threads.
_ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "LP_NUM_THREADS"), "1")


@dataclass(frozen=True)
class Stage:
    """A part of a run.

    Attributes:
        title: what the progress bar says.
        needs: stages whose files it reads.
        work: a function of a module, found again by the worker.

    """

    title: str
    needs: tuple[str, ...]
    work: Work


def run_stages(job: Job, stages: Mapping[str, Stage], workers: int = 2, *, quiet: bool = False) -> None:
    """Do every stage of `job` that is not done; raises what a stage raised, after the others were stopped."""
    with _progress(quiet) as progress, _Pool(job, min(workers, len(stages))) as pool:
        bars = {name: progress.add_task(stage.title, total=None, start=False) for name, stage in stages.items()}
        for name in stages:
            if job.done(name):
                progress.update(bars[name], total=1, completed=1)
        while waiting := [name for name in stages if not job.done(name)]:
            for name in waiting:
                ready = all(job.done(need) for need in stages[name].needs)
                if ready and name not in pool.busy and pool.free:
                    progress.start_task(bars[name])
                    pool.start(name)
            if not pool.busy:
                raise JobError(f"no stage can go on: {', '.join(waiting)} wait for one another")
            for name, message in pool.messages():
                _show(progress, bars[name], message)


def _show(progress: Progress, bar: TaskID, message: tuple[str, int, int | str]) -> None:
    kind, first, second = message
    if kind == "failed":
        raise (InputError if first == InputError.exit_code else JobError)(str(second))
    if kind == "tick":
        progress.update(bar, completed=first, total=int(second))
    else:
        total = progress.tasks[bar].total or 1
        progress.update(bar, completed=total, total=total)


class _Pool:
    """Worker processes, each busy with at most one stage."""

    def __init__(self, job: Job, size: int) -> None:
        self._job = job
        self._size = size
        self._pipes: dict[Connection, BaseProcess] = {}
        self._stages: dict[Connection, str] = {}

    def __enter__(self) -> _Pool:
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

    def start(self, name: str) -> None:
        """Give a stage to a free worker."""
        pipe = next((pipe for pipe in self._pipes if pipe not in self._stages), None) or self._spawn()
        self._stages[pipe] = name
        pipe.send(name)

    def messages(self) -> Iterator[tuple[str, tuple[str, int, int | str]]]:
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
        process = context.Process(target=serve, args=(there, self._job.out), daemon=True)
        with _environment(_ONE_THREAD):
            process.start()
        there.close()
        self._pipes[here] = process
        return here


@contextmanager
def _environment(values: dict[str, str]) -> Iterator[None]:
    before = dict(os.environ)
    os.environ.update(values)
    try:
        yield
    finally:
        os.environ.clear()
        os.environ.update(before)


def _progress(quiet: bool) -> Progress:
    return Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        console=Console(stderr=True),
        disable=quiet,
    )
