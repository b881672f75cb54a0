"""A marker, or an encoder, that is gone from one pose on: not seen is news, not an absence of news."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from armtwin.calib.diagnosis.problem import Problem
from armtwin.calib.diagnosis.structure import Trend

Array = NDArray[np.float64]

# Gone is what is missing from all of the last poses, so many or this share, though it was seen in most before.
_LEAST_POSES = 8
_LEAST_SHARE = 0.05
_MOSTLY = 0.8


def vanished(problem: Problem, predicted: Array) -> Trend | None:
    """Return the first marker, or joint, that is never seen again though `predicted` (N, M, d) lies in the picture."""
    seen: NDArray[np.bool_] = np.asarray(np.isfinite(problem.observed).all(axis=-1))
    inside: NDArray[np.bool_] = np.ones(seen.shape, dtype=bool)
    if problem.is_pixels:
        camera = problem.context.camera
        assert camera is not None
        size = np.array([camera.image_width, camera.image_height])
        inside = np.asarray(((predicted >= 0.0) & (predicted < size)).all(axis=-1))
    n = len(seen)
    found: list[tuple[int, str]] = []
    for channel, name in enumerate(problem.channels):
        first = n - int(np.argmax(seen[::-1, channel])) if seen[:, channel].any() else 0
        wanted = max(_LEAST_POSES, round(_LEAST_SHARE * n))
        if n - first < wanted or first < wanted or seen[:first, channel].mean() < _MOSTLY:
            continue
        if inside[first:, channel].mean() > _MOSTLY:
            found.append((first, f"marker {name.upper()}" if problem.is_pixels else name))
    if not found:
        return None
    row, name = min(found)
    return Trend(f"{name}, which is never seen from pose {row} on", (n - row) / n, 0.0)
