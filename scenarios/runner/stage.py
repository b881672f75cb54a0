"""What a stage of a run is, and how it reports how far it is."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from armtwin.scenarios.runner.job import Job

# Reports how much of a stage is done: (done, total).
Tick = Callable[[int, int], None]
# One stage: reads what earlier stages wrote, returns what goes into its own file.
Work = Callable[[Job, Tick], dict[str, Any]]


@dataclass(frozen=True)
class Stage:
    """A part of a run.

    Attributes:
        title: what the progress bar says.
        needs: stages whose files it reads.
        work: a function of a module, which a worker process can find by its name.
        writes: what it leaves in the run's folder beside its own file; where that is gone it is done again.

    """

    title: str
    needs: tuple[str, ...]
    work: Work
    writes: tuple[str, ...] = ()
