"""The pictures of a capture as PNG files: stored while the arm waits, packed when it no longer does."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from armtwin.models import atomic
from armtwin.models.errors import JobError

Image = NDArray[np.uint8]

# The arm waits for a picture to be written: one of 720p that is only stored takes 3 ms, and 23 ms where it is packed,
# which is half its size. Noise has no repeats to search for; with a search packing takes 48 ms.
_STORED = [*(cv2.IMWRITE_PNG_COMPRESSION, 0), *(cv2.IMWRITE_PNG_FILTER, cv2.IMWRITE_PNG_FILTER_NONE)]
_PACKED = [
    *(cv2.IMWRITE_PNG_COMPRESSION, 1),
    *(cv2.IMWRITE_PNG_FILTER, cv2.IMWRITE_PNG_FILTER_SUB),
    *(cv2.IMWRITE_PNG_STRATEGY, cv2.IMWRITE_PNG_STRATEGY_HUFFMAN_ONLY),
]


def bytes_stored(width: int, height: int) -> int:
    """Return the size of a picture that is only stored, less some bytes of its frame."""
    return 3 * width * height


def store(path: Path, image: Image) -> None:
    """Write an (H, W, 3) BGR picture as quickly as can be; raises `JobError`, or OSError."""
    atomic.write_bytes(path, _png(image, _STORED))


def pack(path: Path, width: int, height: int) -> None:
    """Write a picture that was only stored anew, in about half the bytes; raises OSError."""
    if path.stat().st_size < bytes_stored(width, height):
        return
    image = cv2.imread(str(path), cv2.IMREAD_COLOR)
    if image is not None:
        atomic.write_bytes(path, _png(np.asarray(image, dtype=np.uint8), _PACKED))


def _png(image: Image, options: list[int]) -> bytes:
    good, png = cv2.imencode(".png", image, options)
    if not good:
        raise JobError(f"a picture of shape {image.shape} cannot be written as PNG")
    return png.tobytes()
