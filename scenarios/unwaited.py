"""Threads that nobody waits for: inside a library that does not return when it is asked to."""

from __future__ import annotations

import os
import sys
import threading
from typing import NoReturn

_unwaited: list[threading.Thread] = []


def start_unwaited(thread: threading.Thread) -> None:
    """Start a daemon thread that `leave` does not wait for."""
    _unwaited[:] = [one for one in _unwaited if one.is_alive()]
    _unwaited.append(thread)
    thread.start()


def leave(code: int) -> NoReturn:
    """End this process with an exit code, at once where an unwaited thread still runs.

    The interpreter's own end takes away what such a thread stands on, and the process would crash.
    """
    if not any(thread.is_alive() for thread in _unwaited):
        sys.exit(code)
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)
