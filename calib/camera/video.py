"""Views of a board from a video: the sharp frames that add most to what the others show."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from armtwin.calib.camera.corners import Corners
from armtwin.calib.camera.images import MAX_PIXELS
from armtwin.calib.camera.target import Target
from armtwin.models.errors import InputError

Array = NDArray[np.float64]
Gray = NDArray[np.uint8]

# Frames that are looked at, evenly over the video, and frames that are kept: more tell little more.
_LOOKED_AT, MOST_KEPT = 60, 20
# A frame with less than this share of the typical sharpness is blurred by motion.
_BLURRED = 0.6
# A frame is worth keeping while the board's corners stand this far from those of every kept one, share of the width.
_LEAST_NEW = 0.015


@dataclass(frozen=True, eq=False)
class _Frame:
    view: Corners
    sharpness: float
    place: Array  # (8,) corners of the board, shares of the picture's width


def views_of_video(
    path: Path, target: Target, window_px: int | None = None, tick: Callable[[], None] = lambda: None
) -> tuple[list[Corners], tuple[int, int], int]:
    """Return the chosen views, the frames' (width, height) and how many frames were looked at.

    Raises:
        InputError: no video that can be read, or frames too large.

    """
    if not path.is_file():
        raise InputError(f"{path}: found no plain file, wanted a video")
    video = cv2.VideoCapture(str(path))
    try:
        video.set(cv2.CAP_PROP_ORIENTATION_AUTO, 0)  # the lens does not turn with the picture
        size = int(video.get(cv2.CAP_PROP_FRAME_WIDTH)), int(video.get(cv2.CAP_PROP_FRAME_HEIGHT))
        if not video.isOpened() or not 0 < size[0] * size[1] <= MAX_PIXELS:
            raise InputError(f"{path}: found no video that can be read, wanted one; photographs serve as well")
        count, rate = video.get(cv2.CAP_PROP_FRAME_COUNT), video.get(cv2.CAP_PROP_FPS) or 1.0
        step = max(int(count / _LOOKED_AT), 1) if np.isfinite(count) else 1
        frames, number, looked = [], 0, 0
        while looked < _LOOKED_AT and video.grab():
            if number % step == 0:
                seen, image = video.retrieve()
                if seen and image is not None:
                    looked += 1
                    tick()
                    gray = np.asarray(cv2.cvtColor(image, cv2.COLOR_BGR2GRAY), dtype=np.uint8)
                    view = target.find(f"{path.name} at {number / rate:.1f} s", gray, window_px, thorough=False)
                    if view is not None:
                        frames.append(_Frame(view, _sharpness(gray, view.pixels), _place(target, view, size)))
            number += 1
    finally:
        video.release()
    return [frame.view for frame in _chosen(frames)], size, looked


def _chosen(frames: list[_Frame]) -> list[_Frame]:
    """Frames that are sharp and far from one another, in their order."""
    if not frames:
        return []
    typical = float(np.median([frame.sharpness for frame in frames]))
    left = [frame for frame in frames if frame.sharpness >= _BLURRED * typical]
    kept = [max(left, key=lambda frame: frame.sharpness)]
    while len(kept) < MOST_KEPT:
        new = [min(float(np.abs(frame.place - other.place).max()) for other in kept) for frame in left]
        best = int(np.argmax(new))
        if new[best] < _LEAST_NEW:
            break
        kept.append(left[best])
    return [frame for frame in frames if any(frame is one for one in kept)]


def _sharpness(gray: Gray, pixels: Array) -> float:
    """How much of the board's contrast lies between neighbouring pixels."""
    (u0, v0), (u1, v1) = np.maximum(pixels.min(axis=0), 0).astype(int), pixels.max(axis=0).astype(int) + 1
    part = gray[v0:v1, u0:u1].astype(np.float32)
    return float(cv2.Laplacian(part, cv2.CV_32F).var() / max(float(part.var()), 1.0))


def _place(target: Target, view: Corners, size: tuple[int, int]) -> Array:
    """(8,) where the board's own four corners lie, shares of the width."""
    (x0, y0), (x1, y1) = target.extent_mm
    H, _ = cv2.findHomography(target.points_of(view)[:, :2], view.pixels)
    corners = np.array([[[x0, y0], [x1, y0], [x0, y1], [x1, y1]]])
    return np.asarray(cv2.perspectiveTransform(corners, H).ravel() / size[0], dtype=float)
