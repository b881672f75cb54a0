"""A whole sweep: its cells' worlds on a cluster, kept as they finish, gone on with where it was broken off."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from armtwin.models.errors import InputError
from armtwin.scenarios.sweeps.cluster import cluster
from armtwin.scenarios.sweeps.engine import carry_out
from armtwin.scenarios.sweeps.journal import Journal, Key, code_digest, write_tables
from armtwin.scenarios.sweeps.placing import Placing
from armtwin.scenarios.sweeps.table import SweepTable, cells_of
from armtwin.scenarios.sweeps.trial import Row, Trial, run_trial

# A scheduler that restarts is waited for by so many attempts, of 20 s and this pause each.
_ATTEMPTS = 6
_PAUSE_S = 5.0


class SweepRun:
    """The worlds of a sweep: those that are done (`rows`), those that are sent, and those that wait."""

    def __init__(
        self, table: SweepTable, journal: Journal, progress: Callable[[int, int], None], at_most: int | None = None
    ) -> None:
        cells = cells_of(table)
        self.placings = {cell.number: Placing(table, cell) for cell in cells}
        self._most = len(cells) * (table.trials + table.confirm)
        self._journal, self._progress = journal, progress
        self._left = np.inf if at_most is None else at_most
        self._unasked = deque(self.placings.values())
        self._waiting: deque[Trial] = deque()
        self._sent: dict[Key, Trial] = {}

    @property
    def rows(self) -> dict[Key, Row]:
        """What is known, by (cell, trial)."""
        return self._journal.rows

    def ready(self) -> Iterator[Trial]:
        """Yield worlds that can be made now, each once."""
        while self._left > 0 and (self._waiting or self._unasked):
            if not self._waiting:
                self._ask(self._unasked.popleft())
                continue
            trial = self._waiting.popleft()
            self._sent[trial.key] = trial
            self._left -= 1
            yield trial

    def take(self, row: Row) -> None:
        """Keep a world's row."""
        self._journal.add(row)
        del self._sent[row["cell"], row["trial"]]
        self._ask(self.placings[row["cell"]])
        self._progress(len(self.rows), self._most)

    def send_again(self) -> None:
        """Let what was sent and has not come back wait again: whoever had it is gone."""
        self._waiting.extendleft(self._sent.values())
        self._left += len(self._sent)
        self._sent.clear()

    def recall(self) -> None:
        """Ask the cells that no world was made for now for what is kept of them."""
        while self._unasked:
            self._ask(self._unasked.popleft())

    def _ask(self, placing: Placing) -> None:
        """Ask a cell for its next worlds; those that are kept from an earlier run are not made again."""
        while trials := placing.next_round(self.rows):
            fresh = [trial for trial in trials if trial.key not in self.rows]
            if fresh:
                self._waiting.extend(fresh)
                return


def sweep(
    table: SweepTable,
    out: Path,
    *,
    scheduler: str | None = None,
    workers: int | None = None,
    at_most: int | None = None,
    progress: Callable[[int, int], None] = lambda done, most: None,
    begun: Callable[[str], None] = lambda dashboard: None,
) -> SweepRun:
    """Make and diagnose every world of a sweep that `out` does not hold yet (or `at_most` so many), write its tables.

    `begun` is told the address of the cluster's page. Raises `InputError` where `out` holds another sweep's worlds or
    the scheduler does not answer, `JobError` where the cluster is lost for good or the disk is full; what is finished
    is kept.
    """
    journal = Journal(out, {"table": table.model_dump(mode="json", by_alias=True), "code": code_digest()})
    try:
        run = SweepRun(table, journal, progress, at_most)
        progress(len(run.rows), len(run.placings) * (table.trials + table.confirm))
        for attempt in range(_ATTEMPTS):
            try:
                with cluster(scheduler, workers) as client:
                    begun(client.dashboard_link)
                    carry_out(client, run, run_trial)
                break
            except (OSError, TimeoutError, InputError) as error:
                if scheduler is None or attempt == _ATTEMPTS - 1 or (attempt == 0 and isinstance(error, InputError)):
                    raise
                run.send_again()
                time.sleep(_PAUSE_S)
    finally:
        journal.close()
    run.recall()
    write_tables(out, run.rows)
    return run
