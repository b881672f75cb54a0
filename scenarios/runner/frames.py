"""Frames on disk."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

Image = NDArray[np.uint8]

# Sensor noise hardly compresses: the fastest level loses 3 % of size to the usual one and takes a third of its time.
_FAST = [cv2.IMWRITE_PNG_COMPRESSION, 1]


def write_frame(folder: Path, number: int, image: Image) -> None:
    """Write one frame as `000000.png`; into a folder that is still aside, so not atomic by itself."""
    folder.mkdir(parents=True, exist_ok=True)
    data = cv2.imencode(".png", image, _FAST)[1]
    (folder / f"{number:06d}.png").write_bytes(data.tobytes())


def read_frame(folder: Path, number: int) -> Image:
    """Read a frame that `write_frame` wrote."""
    image = cv2.imread(str(folder / f"{number:06d}.png"), cv2.IMREAD_COLOR)
    return np.asarray(image, dtype=np.uint8)
