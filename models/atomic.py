"""Writes that are whole or not at all: aside first, flushed to disk, then renamed; the new name is flushed as well."""

from __future__ import annotations

import errno
import json
import math
import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

_ASIDE = ".part"
_OLD = ".old"


def write_bytes(path: Path, data: bytes) -> None:
    """Write `data` to `path` atomically, making its parent folders."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with _named(path):
        handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.", suffix=_ASIDE)
        aside = Path(name)
        try:
            with os.fdopen(handle, "wb") as stream:
                stream.write(data)
                stream.flush()
                os.fsync(stream.fileno())
            aside.chmod(0o644)
            aside.replace(path)
            sync_folder(path.parent)
        except BaseException:
            aside.unlink(missing_ok=True)
            raise


def write_text(path: Path, text: str) -> None:
    """Write `text` to `path` atomically as UTF-8."""
    write_bytes(path, text.encode("utf-8"))


def write_json(path: Path, value: object) -> None:
    """Write `value` as indented JSON; NumPy arrays and scalars are accepted, what is not finite becomes null."""
    write_text(path, json.dumps(_plain(value), indent=1, ensure_ascii=False, allow_nan=False) + "\n")


@contextmanager
def folder_aside(target: Path) -> Iterator[Path]:
    """Yield an empty folder beside `target` that takes its place when the block ends well, and goes when it fails."""
    target.parent.mkdir(parents=True, exist_ok=True)
    with _named(target):
        aside = Path(tempfile.mkdtemp(dir=target.parent, prefix=f".{target.name}.", suffix=_ASIDE))
    try:
        aside.chmod(0o755)
        yield aside
        if target.exists():
            old = Path(tempfile.mkdtemp(dir=target.parent, prefix=f".{target.name}.", suffix=_OLD))
            target.replace(old / target.name)
            aside.replace(target)
            sync_folder(target.parent)
            shutil.rmtree(old)
        else:
            aside.replace(target)
            sync_folder(target.parent)
    except BaseException:
        shutil.rmtree(aside, ignore_errors=True)
        raise


@contextmanager
def _named(path: Path) -> Iterator[None]:
    """Let what fails name what was to be written: not the one aside, and a full disk names none."""
    try:
        yield
    except OSError as error:
        error.filename = str(path)
        raise


def sync_folder(folder: Path) -> None:
    """Flush the names in `folder` to disk: until then a power cut may take back what was made or renamed there."""
    try:
        handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    except PermissionError:  # one may write into it, but not look
        return
    try:
        os.fsync(handle)
    except OSError as error:
        if error.errno != errno.EINVAL:  # some network file systems know no flush of a folder
            raise
    finally:
        os.close(handle)


def leftovers(folder: Path) -> list[Path]:
    """Return what writers that were killed left aside in `folder` and below it."""
    return [*folder.rglob(f".*{_ASIDE}"), *folder.rglob(f".*{_OLD}")]


def clear_leftovers(folder: Path) -> None:
    """Remove what writers that were killed left aside in `folder` and below it; nobody may be writing there now."""
    for left in leftovers(folder):
        if left.is_dir():
            shutil.rmtree(left)
        else:
            left.unlink(missing_ok=True)


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, np.ndarray):
        return _plain(value.tolist())
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    if isinstance(value, np.generic):
        return _plain(value.item())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    if isinstance(value, Path):
        return value.as_posix()
    return value
