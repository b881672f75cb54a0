"""Reading TOML files that a person wrote: whatever is wrong with the file is one line that names it."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

from armtwin.models.errors import InputError

# Arm, servo and scenario files are a few kilobytes.
_MAX_BYTES = 1 << 20


def read_toml(path: Path) -> dict[str, Any]:
    """Return the tables of a TOML file; raises `InputError` where there is none, or it is no TOML or far too large."""
    try:
        if path.exists() and not path.is_file():  # a pipe or a device would be read without end
            raise InputError(f"{path}: a folder, a pipe or a device; a TOML file is wanted")
        if path.stat().st_size > _MAX_BYTES:
            raise InputError(f"{path.name}: larger than {_MAX_BYTES} bytes, no TOML file of this project")
        return tomllib.loads(path.read_text("utf-8-sig"))
    except FileNotFoundError:
        raise InputError(f"{path}: no such file") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror}); a TOML file is wanted") from None
    except (ValueError, RecursionError) as error:  # no TOML, no UTF-8, a whole number of thousands of digits
        raise InputError(f"{path.name}: not TOML ({error})") from None
