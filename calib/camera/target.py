"""What is photographed to calibrate a camera: a flat board with points that a detector finds and tells apart."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol, Self

import numpy as np
from numpy.typing import NDArray

from armtwin.calib.camera.corners import Corners

Array = NDArray[np.float64]
Gray = NDArray[np.uint8]


class Target(Protocol):
    """A board. Its frame: x runs along the columns, y along the rows, z = x × y points away from the camera."""

    @property
    def points_mm(self) -> Array:
        """(N, 3) points in the board frame, mm."""

    @property
    def n_corners(self) -> int:
        """Number of points."""

    @property
    def extent_mm(self) -> Array:
        """(2, 2) least and greatest x, y of the points, mm."""

    @property
    def square_mm(self) -> float:
        """Side of a square, or distance of two circles, mm."""

    def find(self, name: str, image: Gray, window_px: int | None = None, thorough: bool = True) -> Corners | None:
        """Find the points in a picture; None where there are too few. `thorough` takes longer where none are."""

    def points_of(self, view: Corners) -> Array:
        """(N, 3) board points of a view's pixels, mm."""

    def y_down_px(self, view: Corners) -> float:
        """How far the board's y axis points down in the view, px."""

    def half_turned(self, views: Sequence[Corners]) -> tuple[Self, list[Corners]]:
        """Return the board and its views with the frame turned by half a turn in its plane."""

    def __str__(self) -> str:
        """What it is, for people."""
