"""How long a bench takes must not say what is in it: what it did too quickly is waited for afterwards.

MuJoCo needs eight times as long for an arm with play as for one without (17 ms a move against 2). So a move of a sealed
bench counts as whole beats, and whoever asked for it has his answer when they are over. The bench's thread, which
others share, is not held up meanwhile.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from contextlib import contextmanager


class Pace:
    """What a bench still owes, s; its work and its paying are each done by one thread, one after the other."""

    def __init__(self) -> None:
        self._owed_s = 0.0

    @contextmanager
    def beats(self, beat_s: float) -> Iterator[None]:
        """Count what is done here as whole beats of `beat_s`, whether it ends well or not."""
        began = time.monotonic()
        try:
            yield
        finally:
            took = time.monotonic() - began
            self._owed_s += max(1, math.ceil(took / beat_s)) * beat_s - took

    def pay(self) -> None:
        """Wait for what is owed."""
        owed, self._owed_s = self._owed_s, 0.0
        time.sleep(owed)
