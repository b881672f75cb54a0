"""Worlds over the workers of a cluster, a few to each at a time; what is lost with a worker is sent again."""

from __future__ import annotations

import queue
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import CancelledError
from itertools import islice
from typing import Protocol

from distributed import Client, Future, KilledWorker

from armtwin.models.errors import JobError
from armtwin.scenarios.sweeps.trial import Row, Trial

# So many worlds wait at each worker: it never runs dry, and the scheduler holds few however many there are.
_AHEAD = 3
# Without a result for so long the scheduler is asked whether it still has workers.
_QUIET_S = 60.0
_FAILED = ("cancelled", "lost")


class Source(Protocol):
    """Where worlds come from: more are asked for as others finish."""

    def ready(self) -> Iterator[Trial]:
        """Yield worlds that can be made now; each is yielded once."""

    def take(self, row: Row) -> None:
        """Keep what came of one."""


def carry_out(client: Client, source: Source, function: Callable[[Trial], Row]) -> None:
    """Run `function` over all worlds of a source.

    Raises `JobError` for a world that brings down every worker it is given to, or where no worker is left, and
    `OSError` where the scheduler itself is gone.
    """
    finished: queue.SimpleQueue[Future[Row]] = queue.SimpleQueue()
    pending: dict[str, tuple[Future[Row], Trial]] = {}
    begun = 0

    def send(trials: Iterable[Trial]) -> None:
        nonlocal begun
        for trial in trials:
            begun += 1
            future = client.submit(function, trial, key=f"world-{trial.key[0]}-{trial.key[1]}-{begun}", pure=False)
            pending[str(future.key)] = (future, trial)
            future.add_done_callback(finished.put)

    def top_up() -> None:
        room = max(_AHEAD * sum(client.nthreads().values()), _AHEAD) - len(pending)
        if room > 0:
            send(islice(source.ready(), room))

    top_up()
    while pending:
        try:
            future = finished.get(timeout=_QUIET_S)
        except queue.Empty:
            if not client.nthreads():
                raise JobError("no worker is left; start some, the same command goes on from here") from None
            continue
        _, trial = pending.pop(str(future.key))
        if future.status in _FAILED:
            if client.status != "running":
                raise OSError("the scheduler is gone")
            send([trial])
            continue
        try:
            source.take(future.result())
        except (CancelledError, KeyError):
            send([trial])
        except KilledWorker:
            raise JobError(
                f"world {trial.key[0]}/{trial.key[1]} brought down every worker that it was given to (memory?); "
                "finished worlds are kept"
            ) from None
        future.release()
        top_up()
