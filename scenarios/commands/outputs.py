"""Where results go: what cannot be written is refused before any work is done."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from armtwin.models import atomic
from armtwin.models.errors import InputError
from armtwin.models.folder_lock import only_writer


def check_out_folder(out: Path) -> None:
    """Raise `InputError` where `out` is no folder and none can be made there by this user."""
    try:
        if out.exists() and not out.is_dir():
            raise InputError(f"{out}: is a file, --out wants a folder")
        if out.is_symlink() and not out.exists():
            raise InputError(f"{out}: a link that leads nowhere, --out wants a folder")
        standing = next(path for path in (out.absolute(), *out.absolute().parents) if path.exists())
    except OSError as error:
        raise InputError(f"--out {out}: no folder can be made there ({error.strerror})") from None
    if not standing.is_dir():
        raise InputError(f"--out {out}: {standing} is a file, a folder is wanted there")
    if not os.access(standing, os.W_OK | os.X_OK):
        raise InputError(f"--out {out}: the folder {standing} may not be written to by this user")


@contextmanager
def only_results(out: Path) -> Iterator[None]:
    """Hold the folder of the results while the block makes them, made where it is not there yet.

    What a killed command left aside in it is cleared; a folder that the block leaves empty goes again. Raises
    `InputError` where another armtwin is at work in it.
    """
    check_out_folder(out)
    new = not out.exists()
    out.mkdir(parents=True, exist_ok=True)
    try:
        with only_writer(out):
            atomic.clear_leftovers(out, below=False)
            yield
    except BaseException:
        if new:
            with suppress(OSError):  # not empty: something was finished
                out.rmdir()
        raise
