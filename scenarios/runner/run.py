"""Run the stages that are not done yet, two at a time where they do not wait for each other."""

from __future__ import annotations

from collections.abc import Mapping
from graphlib import CycleError, TopologicalSorter

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TaskID, TextColumn, TimeElapsedColumn

from armtwin.models.errors import InputError, JobError
from armtwin.scenarios.runner.job import Job
from armtwin.scenarios.runner.pool import Message, WorkerPool
from armtwin.scenarios.runner.stage import Stage


def run_stages(job: Job, stages: Mapping[str, Stage], workers: int = 2, *, quiet: bool = False) -> None:
    """Do every stage of `job` that is not done; raises what a stage raised, after the others were stopped."""
    order = _order(stages)
    with _progress(quiet) as progress, WorkerPool(job, min(workers, len(stages))) as pool:
        bars = {name: progress.add_task(stage.title, total=None, start=False) for name, stage in stages.items()}
        ready: list[str] = []
        while order.is_active():
            ready = sorted([*ready, *order.get_ready()], key=list(stages).index)
            for name in [name for name in ready if job.done(name, stages[name].writes)]:
                progress.update(bars[name], total=1, completed=1)
                ready.remove(name)
                order.done(name)
            while ready and pool.free:
                name = ready.pop(0)
                progress.start_task(bars[name])
                pool.start(name, stages[name].work)
            for name, message in pool.messages() if pool.busy else ():
                _show(progress, bars[name], message)
                if message[0] == "done":
                    order.done(name)


def _order(stages: Mapping[str, Stage]) -> TopologicalSorter[str]:
    """Return the order in which stages can be done; raises `JobError` where some wait for one another."""
    order = TopologicalSorter({name: stage.needs for name, stage in stages.items()})
    try:
        order.prepare()
    except CycleError as error:
        raise JobError(f"no stage can go on: {', '.join(error.args[1][1:])} wait for one another") from None
    return order


def _show(progress: Progress, bar: TaskID, message: Message) -> None:
    kind, first, second = message
    if kind == "failed":
        raise (InputError if first == InputError.exit_code else JobError)(str(second))
    if kind == "tick":
        progress.update(bar, completed=first, total=int(second))
    else:
        total = progress.tasks[bar].total or 1
        progress.update(bar, completed=total, total=total)


def _progress(quiet: bool) -> Progress:
    return Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        console=Console(stderr=True),
        disable=quiet,
    )
