"""Matrices as YAML, JSON and XML files write them: OpenCV's blocks, nested lists, flat lists."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from armtwin.models.errors import InputError

Array = NDArray[np.float64]

# More numbers than any lens or matrix has.
_MOST = 1000


def numbers(key: str, found: object) -> Array:
    """(n,) numbers of a block with `data`, or of a list, nested or flat; none where there is nothing.

    Raises:
        InputError: something else, or what is no finite number; starts with the key.

    """
    data = found.get("data") if isinstance(found, dict) else found
    if data is None:
        return np.zeros(0)
    if not isinstance(data, list):
        raise InputError(f"{key}: found {type(data).__name__}, wanted rows, cols and data, or a list of numbers")
    flat = [item for part in data[:_MOST] for item in (part[:_MOST] if isinstance(part, list) else [part])]
    bad = [item for item in flat if isinstance(item, bool) or not isinstance(item, (int, float))]
    if bad or len(flat) > _MOST:
        what = f"{type(bad[0]).__name__} {str(bad[0])[:40]!r}" if bad and not isinstance(bad[0], list) else "too much"
        raise InputError(f"{key}: found {what} in data, wanted numbers")
    try:
        values = np.array(flat, dtype=float)
    except OverflowError:
        raise InputError(f"{key}: found a number too large in data, wanted finite numbers") from None
    if not np.all(np.isfinite(values)):
        raise InputError(f"{key}: found a number that is not finite in data, wanted finite numbers")
    return values


def block(key: str, found: object, shape: tuple[int, int] | None = None) -> Array:
    """(n,) numbers of a block with rows and cols that fit its data and, where given, the shape.

    Raises:
        InputError: they do not fit; starts with the key.

    """
    values = numbers(key, found)
    if isinstance(found, dict) and ("rows" in found or "cols" in found):
        rows, cols = found.get("rows"), found.get("cols")
        whole = all(isinstance(n, int) and not isinstance(n, bool) and n >= 0 for n in (rows, cols))
        if not whole or not isinstance(rows, int) or not isinstance(cols, int):
            raise InputError(f"{key}: found rows {rows!r} and cols {cols!r}, wanted whole numbers")
        if values.size != rows * cols:
            raise InputError(f"{key}: found {values.size} numbers in data, wanted rows x cols = {rows} x {cols}")
        if shape is not None and (rows, cols) != shape:
            raise InputError(f"{key}: found {rows} rows and {cols} cols, wanted {shape[0]} and {shape[1]}")
    if shape is not None and values.size != shape[0] * shape[1]:
        found_text = "nothing" if not values.size else f"{values.size} numbers"
        raise InputError(f"{key}: found {found_text}, wanted {shape[0]} x {shape[1]} numbers in rows, cols and data")
    return values


def board_pose(content: Mapping[str, Any]) -> tuple[Array, Array] | tuple[None, None]:
    """(3, 3) rotation and (3,) translation, mm, of armtwin's own two keys, or nothing where neither is there."""
    names = ("board_to_camera_rotation", "board_to_camera_translation_mm")
    if not any(name in content for name in names):
        return None, None
    R = block(names[0], content.get(names[0]), (3, 3)).reshape(3, 3)
    return R, block(names[1], content.get(names[1]), (3, 1))
