"""How much of the image the corners of all views cover: a lens is known only where corners were seen."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

# Cells over the image (columns, rows); each of the nine regions holds 4 x 4 of them.
GRID = (12, 12)
REGIONS = (
    ("top left", "top", "top right"),
    ("left", "centre", "right"),
    ("bottom left", "bottom", "bottom right"),
)
# A region with corners in fewer than this share of its cells is called empty.
_EMPTY_BELOW = 0.25


@dataclass(frozen=True, eq=False)
class Coverage:
    """Coverage of the image.

    Attributes:
        counts: (12, 12) corners in each cell, rows from the top.
        hull_share: area of the convex hull of all corners over that of the image.
        reach_share: distance of the farthest corner from the image's centre over that of the image's own corners.
        empty_regions: those of the nine regions of the image that hold few corners or none.

    """

    counts: Array
    hull_share: float
    reach_share: float
    empty_regions: tuple[str, ...]

    @property
    def cell_share(self) -> float:
        """Share of the cells that hold a corner."""
        return float(np.mean(self.counts > 0))


def cover(pixels: Array, image_size: tuple[int, int]) -> Coverage:
    """Return the coverage of an image of (width, height) pixels by (N, 2) corners."""
    size = np.array(image_size, dtype=float)
    # The picture reaches from -0.5 to size - 0.5, as the first pixel's centre is (0, 0).
    u, v = (pixels + 0.5).T
    bounds = [[0.0, size[1]], [0.0, size[0]]]
    counts, _, _ = np.histogram2d(v, u, bins=(GRID[1], GRID[0]), range=bounds)
    hull = cv2.convexHull(pixels.astype(np.float32))
    centre = (size - 1.0) / 2.0
    filled = (counts > 0).reshape(3, GRID[1] // 3, 3, GRID[0] // 3).mean(axis=(1, 3))
    empty = [REGIONS[row][column] for row in range(3) for column in range(3) if filled[row, column] < _EMPTY_BELOW]
    return Coverage(
        counts=counts,
        hull_share=float(cv2.contourArea(hull) / np.prod(size)),
        reach_share=float(np.linalg.norm(pixels - centre, axis=1).max() / np.linalg.norm(size / 2.0)),
        empty_regions=tuple(empty),
    )
