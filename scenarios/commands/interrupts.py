"""Signals that end a command: all of them as Ctrl-C does, and none of them lost."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

Handler = Callable[[int, FrameType | None], None]

# A request to end, and a terminal that was closed.
_ENDING = (signal.SIGTERM, signal.SIGHUP)


@contextmanager
def ended_as_by_ctrl_c() -> Iterator[None]:
    """While it lasts these signals raise KeyboardInterrupt: every `finally` runs, so that the servos are detached."""

    def interrupt(number: int, frame: FrameType | None) -> None:
        raise KeyboardInterrupt

    with _handled(interrupt, _ENDING):
        yield


@contextmanager
def interrupts_deferred() -> Iterator[None]:
    """While it lasts Ctrl-C and its like wait; they are raised at its end.

    In the middle of an import they would be lost: packages that try for an optional one take them for its absence.
    """
    came: list[int] = []

    def note(number: int, frame: FrameType | None) -> None:
        came.append(number)

    with _handled(note, (signal.SIGINT, *_ENDING)):
        yield
    if came:
        signal.raise_signal(came[0])


@contextmanager
def _handled(handler: Handler, numbers: tuple[signal.Signals, ...]) -> Iterator[None]:
    """Let a handler have these signals while the block lasts."""
    before = {number: signal.signal(number, handler) for number in numbers}
    try:
        yield
    finally:
        for number, usual in before.items():
            signal.signal(number, usual)
