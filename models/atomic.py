"""Writes that are whole or not at all: aside first, flushed to disk, then renamed; the new name is flushed as well."""

from __future__ import annotations

import errno
import fcntl
import glob
import json
import math
import os
import shutil
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

_ASIDE = ".part"
_OLD = ".old"
_JUST_MADE_S = 5.0


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
    for old in target.parent.glob(f".{glob.escape(target.name)}.*{_ASIDE}"):
        clear_if_left(old)
    with _named(target):
        aside = Path(tempfile.mkdtemp(dir=target.parent, prefix=f".{target.name}.", suffix=_ASIDE))
    held = hold(aside)
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
    finally:
        os.close(held)


def hold(folder: Path) -> int:
    """Return a handle that tells others, until it is closed or this program ends, that a folder is being worked in."""
    handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    return handle


def clear_if_left(folder: Path, older_than_s: float = _JUST_MADE_S) -> None:
    """Remove a temporary folder that nobody holds any more: its program was killed. A younger one is left alone."""
    try:
        if time.time() - folder.stat().st_mtime < older_than_s:  # made, but maybe not held yet
            return
        handle = hold(folder)
    except OSError:
        return
    try:
        shutil.rmtree(folder, ignore_errors=True)
    finally:
        os.close(handle)


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


def leftovers(folder: Path, *, below: bool = True) -> list[Path]:
    """Return what writers that were killed left aside in `folder`, and below it unless that is not wanted."""
    look = folder.rglob if below else folder.glob
    return [*look(f".*{_ASIDE}"), *look(f".*{_OLD}")]


def clear_leftovers(folder: Path, *, below: bool = True) -> None:
    """Remove what `leftovers` finds; nobody may be writing there now."""
    for left in leftovers(folder, below=below):
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
