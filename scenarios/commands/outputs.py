"""Where results go: what cannot be written is refused before any work is done."""

from __future__ import annotations

import os
from pathlib import Path

from armtwin.models.errors import InputError


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
