"""Which views to drop, and which to add."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armtwin.calib.camera.coverage import Coverage
from armtwin.models.statistics import MAD_TO_STD

Array = NDArray[np.float64]

# A view is poor when its error lies this many robust standard deviations above the median of all views, and is this
# many times the median, so that views which are all alike do not lose their last.
_POOR_SIGMAS = 3.5
_POOR_TIMES = 1.5
# Below this many views more are wanted; the paper took twenty.
ENOUGH_VIEWS = 10
# Distortion grows with the third to seventh power of the distance from the centre, so it has to be seen far out.
ENOUGH_REACH = 0.8
# A tilt of less tells little about the focal length: its effect grows with the sine (Zhang 2000, figure 4).
TILTED_RAD = np.deg2rad(15.0)
# Unit vectors in the picture (u right, v down), to the side of the board that a tilt brings nearer to the camera.
_SIDES = {"left": (-1.0, 0.0), "right": (1.0, 0.0), "top": (0.0, -1.0), "bottom": (0.0, 1.0)}


@dataclass(frozen=True)
class Advice:
    """What would make the calibration better.

    `drop` names views whose error is out of line with the others'; `add` says in words which views are missing.
    """

    drop: tuple[str, ...]
    add: tuple[str, ...]


def advise(names: Sequence[str], per_view_rms_px: Array, rotations: Array, coverage: Coverage) -> Advice:
    """Judge the views by their errors (V,), the board's rotations (V, 3, 3) and the coverage of the image."""
    drop = tuple(name for name, poor in zip(names, poor_views(per_view_rms_px), strict=True) if poor)
    add = []
    if len(names) - len(drop) < ENOUGH_VIEWS:
        add.append(f"more views: {len(names) - len(drop)} good ones here, 10 to 20 are usual")
    if coverage.empty_regions:
        add.append(f"views with the board at the {', '.join(coverage.empty_regions)} of the picture")
    if coverage.reach_share < ENOUGH_REACH:
        add.append(
            f"views with the board in the picture's corners: those here reach {coverage.reach_share:.0%} of the way, "
            "and the distortion beyond is extrapolated"
        )
    missing = missing_tilts(rotations)
    if missing:
        add.append(f"views with the board's {', '.join(missing)} side tilted 30 to 45 degrees towards the camera")
    return Advice(drop, tuple(add))


def poor_views(per_view_rms_px: Array) -> NDArray[np.bool_]:
    """(V,) whether a view's error is out of line, by median and median absolute deviation.

    At least three views are always left: the worst beyond that number are kept to be judged again with better company.
    """
    median = np.median(per_view_rms_px)
    sigma = MAD_TO_STD * np.median(np.abs(per_view_rms_px - median))
    limit = max(median + _POOR_SIGMAS * sigma, _POOR_TIMES * median)
    poor = per_view_rms_px > limit
    poor[np.argsort(per_view_rms_px)[:3]] = False
    result: NDArray[np.bool_] = poor
    return result


def tilts(rotations: Array) -> Array:
    """(V, 2) tilt of the board in each view: its angle, rad, along the picture's direction of the nearer side."""
    normals = rotations[:, :, 2]  # the board's z axis points away from the camera
    sideways = np.linalg.norm(normals[:, :2], axis=1, keepdims=True)
    angle = np.arctan2(sideways, normals[:, 2:])
    # Where the normal leans to the right, the plane recedes to the left: the right side is nearer.
    return normals[:, :2] / np.maximum(sideways, 1e-12) * angle


def missing_tilts(rotations: Array) -> tuple[str, ...]:
    """Sides of the board that no view brings nearer to the camera by a tilt of at least 15 degrees."""
    tilt = tilts(rotations)
    return tuple(side for side, way in _SIDES.items() if not np.any(tilt @ np.array(way) >= TILTED_RAD))
