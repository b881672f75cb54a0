"""How a stage reports how far it is."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from armtwin.scenarios.runner.job import Job

# Reports how much of a stage is done: (done, total).
Tick = Callable[[int, int], None]
# One stage: reads what earlier stages wrote, returns what goes into its own file.
Work = Callable[[Job, Tick], dict[str, Any]]
