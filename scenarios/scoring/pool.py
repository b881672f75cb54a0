"""Many independent calls over a few processes."""

from __future__ import annotations

import multiprocessing
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from typing import TypeVar

from armtwin.models.catalogue.registry import registered_files
from armtwin.scenarios.processes import begin_worker, one_thread_each

Key = TypeVar("Key")
Task = TypeVar("Task")
Result = TypeVar("Result")


def gathered(
    function: Callable[[Task], Result],
    left: Sequence[tuple[str, Task]],
    kept: dict[str, Result],
    jobs: int,
    progress: Callable[[int, int], None],
) -> dict[str, str]:
    """Add the results of what is `left` to those `kept`; return what was raised in place of a result, by name.

    `progress` hears how many are done, and how many there are.
    """
    total, broken = len(kept) + len(left), dict[str, str]()
    progress(len(kept), total)
    for name, result in in_processes(function, left, min(jobs, max(len(left), 1))):
        if isinstance(result, BaseException):
            broken[name] = f"{type(result).__name__}: {result}"
        else:
            kept[name] = result
        progress(len(kept) + len(broken), total)
    return broken


def in_processes(
    function: Callable[[Task], Result], tasks: Iterable[tuple[Key, Task]], jobs: int
) -> Iterator[tuple[Key, Result | BaseException]]:
    """Yield (key, result) of `function` for each (key, task) as they are done, or (key, what was raised).

    Processes are spawned, not forked: a fork after an OpenGL context exists hangs.
    """
    spawn = multiprocessing.get_context("spawn")
    with one_thread_each(), ProcessPoolExecutor(jobs, spawn, begin_worker, (registered_files(),)) as pool:
        pending: dict[Future[Result], Key] = {pool.submit(function, task): key for key, task in tasks}
        try:
            for future in as_completed(pending):
                error = future.exception()
                yield pending[future], future.result() if error is None else error
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise
