"""Frames on disk."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from armtwin.models.errors import InputError

Image = NDArray[np.uint8]

# Sensor noise hardly compresses: the fastest level loses 3 % of size to the usual one and takes a third of its time.
_FAST = [cv2.IMWRITE_PNG_COMPRESSION, 1]


def write_frame(folder: Path, number: int, image: Image) -> None:
    """Write one frame as `000000.png`; into a folder that is still aside, so not atomic by itself."""
    folder.mkdir(parents=True, exist_ok=True)
    data = cv2.imencode(".png", image, _FAST)[1]
    (folder / f"{number:06d}.png").write_bytes(data.tobytes())


def read_frame(folder: Path, number: int) -> Image:
    """Read a frame that `write_frame` wrote; raises `InputError` where it is gone or was cut off."""
    path = folder / f"{number:06d}.png"
    image = cv2.imread(str(path), cv2.IMREAD_COLOR)
    if image is None:
        raise InputError(f"{path}: no picture that can be read; remove the run's folder and run the scenario again")
    return np.asarray(image, dtype=np.uint8)
