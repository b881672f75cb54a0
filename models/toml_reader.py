"""Reading TOML files that a person wrote: whatever is wrong with the file is one line that names it."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

from models.errors import InputError

# Arm, servo and scenario files are a few kilobytes.
_MAX_BYTES = 1 << 20


def read_toml(path: Path) -> dict[str, Any]:
    """Return the tables of a TOML file; raises `InputError` where there is none, or it is no TOML or far too large."""
    try:
        if path.stat().st_size > _MAX_BYTES:
            raise InputError(f"{path.name}: larger than {_MAX_BYTES} bytes, no TOML file of this project")
        return tomllib.loads(path.read_text("utf-8"))
    except (FileNotFoundError, IsADirectoryError):
        raise InputError(f"{path}: no such file") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise InputError(f"{path.name}: not TOML ({error})") from None
