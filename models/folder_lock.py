"""One writer at a time in a folder: held by its program until that ends, however it ends."""

from __future__ import annotations

import fcntl
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from armtwin.models.errors import InputError


def hold_folder(folder: Path) -> int:
    """Return an open handle of a folder that nobody else holds until it is closed; raises `InputError` if one does."""
    handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        os.close(handle)
        raise InputError(f"{folder}: another armtwin is at work there; wait for it or choose another --out") from None
    return handle


@contextmanager
def only_writer(folder: Path) -> Iterator[None]:
    """Hold a folder while the block lasts; raises as `hold_folder` does."""
    handle = hold_folder(folder)
    try:
        yield
    finally:
        os.close(handle)
