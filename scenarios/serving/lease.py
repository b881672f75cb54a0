"""One mover at a time: whoever commands the arm holds a lease, and loses it when he is not heard any more."""

from __future__ import annotations

import secrets
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from armtwin.models.errors import JobError

# A page asks for the state every second, a program's bench calls every three: five calls may be lost.
SILENCE_S = 15.0


class LeaseError(JobError):
    """The arm is somebody else's, or nobody's."""


class MoverLease:
    """The right to command the arm, of one holder; `now` is a clock in seconds."""

    def __init__(self, silence_s: float = SILENCE_S, now: Callable[[], float] = time.monotonic) -> None:
        self._silence_s = silence_s
        self._now = now
        self._key: str | None = None
        self._heard_s = 0.0
        self._calls = 0

    @property
    def held(self) -> bool:
        """Whether somebody holds it and was heard of late."""
        return self._key is not None and (self._calls > 0 or self._now() - self._heard_s <= self._silence_s)

    @property
    def lapsed(self) -> bool:
        """Whether its holder fell silent; the arm is then to be detached."""
        return self._key is not None and not self.held

    def take(self) -> str:
        """Return a new key; raises `LeaseError` while somebody else holds it."""
        if self.held:
            raise LeaseError("the arm is being moved by somebody else; wait until it is given back")
        self._key = secrets.token_urlsafe(16)
        self._heard_s = self._now()
        return self._key

    def hear(self, key: str | None) -> bool:
        """Note that the holder is there; return whether `key` is his."""
        if key is None or self._key is None or not self.held or not secrets.compare_digest(key, self._key):
            return False
        self._heard_s = self._now()
        return True

    def check(self, key: str | None) -> None:
        """Raise `LeaseError` unless `key` is the holder's."""
        if not self.hear(key):
            raise LeaseError("this needs the arm, which you do not hold (any more); take it first")

    @contextmanager
    def at_work(self) -> Iterator[None]:
        """While a call of the holder's is done he is not silent, however long he waits for his turn."""
        self._calls += 1
        try:
            yield
        finally:
            self._calls -= 1
            self._heard_s = self._now()

    def end(self) -> None:
        """Let the next one take it."""
        self._key = None
