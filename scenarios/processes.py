"""Processes that do not outlive the one that started them, and that keep to one thread."""

from __future__ import annotations

import multiprocessing
import os
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from armtwin.models.catalogue.registry import register_file

# More threads of linear algebra would only compete for the same cores, and sums would depend on how they are split.
_ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "LP_NUM_THREADS"), "1")


def end_with_parent() -> None:
    """End this process as soon as the one that spawned it is gone, by kill -9 too, whatever it is doing then.

    What it was writing stays aside (`armtwin.models.atomic`); the next run clears it.
    """
    parent = multiprocessing.parent_process()
    if parent is None:
        return

    def watch() -> None:
        parent.join()
        os._exit(1)

    threading.Thread(target=watch, name="end-with-parent", daemon=True).start()


def begin_worker(effects: Sequence[Path]) -> None:
    """Begin a spawned process: it ends with its parent, and knows the effects of the files that its parent does."""
    end_with_parent()
    for path in effects:
        register_file(path)


@contextmanager
def one_thread_each() -> Iterator[None]:
    """While the block lasts, processes inherit that their linear algebra uses one thread."""
    before = dict(os.environ)
    os.environ.update(_ONE_THREAD)
    try:
        yield
    finally:
        os.environ.clear()
        os.environ.update(before)
