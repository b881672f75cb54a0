"""Grids of circles, symmetric or not, by OpenCV's detector.

What is found is the centre of each circle's picture, which a tilt and a lens move off the picture of its centre; with
circles of a third of their spacing that is some hundredths of a pixel in a webcam's picture.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from armtwin.calib.camera.board import check_square, columns_and_rows
from armtwin.calib.camera.charuco import y_slope_px
from armtwin.calib.camera.corners import Corners, reduced

Array = NDArray[np.float64]
Gray = NDArray[np.uint8]


@dataclass(frozen=True)
class CircleGrid:
    """A grid of `columns` x `rows` circles, as OpenCV counts them: of a staggered one, each row has `columns`.

    `square_mm` is the distance of two rows; in a row of a staggered grid the circles are twice as far apart.
    """

    columns: int
    rows: int
    square_mm: float
    staggered: bool = False
    turned: bool = False

    @classmethod
    def parse(cls, text: str, square_mm: float, staggered: bool) -> CircleGrid:
        """Return the grid of a text such as "4x11".

        Raises:
            InputError: these make no grid.

        """
        columns, rows = columns_and_rows(text, "circles, such as 7x6, or 4x11 where rows are staggered")
        check_square(square_mm)
        return cls(columns, rows, square_mm, staggered)

    @property
    def n_corners(self) -> int:
        """Number of circles."""
        return self.columns * self.rows

    @property
    def points_mm(self) -> Array:
        """(N, 3) centres, mm, row after row."""
        row, column = np.mgrid[0 : self.rows, 0 : self.columns]
        x = 2 * column + row % 2 if self.staggered else column
        points = np.stack([x.ravel(), row.ravel(), np.zeros(self.n_corners)], axis=1) * self.square_mm
        return points.max(axis=0) - points if self.turned else points

    @property
    def extent_mm(self) -> Array:
        """(2, 2) least and greatest x, y of the centres, mm."""
        points = self.points_mm
        return np.stack([points.min(axis=0), points.max(axis=0)])[:, :2]

    def find(self, name: str, image: Gray, window_px: int | None = None, thorough: bool = True) -> Corners | None:
        """Find all circles in a picture, dark on light; None where they are not all seen."""
        small, scale = reduced(image)
        size = (self.columns, self.rows)
        kind = cv2.CALIB_CB_ASYMMETRIC_GRID if self.staggered else cv2.CALIB_CB_SYMMETRIC_GRID
        for flags in (kind, kind | cv2.CALIB_CB_CLUSTERING):
            seen, centres = cv2.findCirclesGrid(small, size, flags=flags)
            if seen:
                places = (np.asarray(centres, dtype=float).reshape(-1, 2) + 0.5) * scale - 0.5
                return Corners(name, self._right_handed(places))
        return None

    def points_of(self, view: Corners) -> Array:
        """(N, 3) board points of a view's pixels, mm."""
        return self.points_mm if view.ids is None else self.points_mm[view.ids]

    def y_down_px(self, view: Corners) -> float:
        """How far the board's y axis points down in the view, px."""
        return y_slope_px(self.points_of(view), view.pixels)

    def half_turned(self, views: Sequence[Corners]) -> tuple[CircleGrid, list[Corners]]:
        """Return the grid with its frame turned; the views stay as they are."""
        return replace(self, turned=not self.turned), list(views)

    def __str__(self) -> str:
        """What it is, for people."""
        return f"{self.columns}x{self.rows} circles{', rows staggered' if self.staggered else ''}"

    def _right_handed(self, places: Array) -> Array:
        """Circles in an order in which x × y points away from the camera, y down: all views alike."""
        if self.staggered:
            return places
        grid = places.reshape(self.rows, self.columns, 2)
        along, down = grid[0, -1] - grid[0, 0], grid[-1, 0] - grid[0, 0]
        if along[0] * down[1] - along[1] * down[0] < 0.0:
            grid = grid[:, ::-1]
        if (grid[-1] - grid[0])[:, 1].mean() < 0.0:  # the grid does not tell its ends apart; people hold it upright
            grid = grid[::-1, ::-1]
        return grid.reshape(-1, 2)
