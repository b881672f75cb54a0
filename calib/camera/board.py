"""The chessboard: its inner corners, their order and the frame that they span."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armtwin.calib.camera.corners import Corners, find_corners, y_down_px
from armtwin.models.errors import InputError

Array = NDArray[np.float64]
Gray = NDArray[np.uint8]

# OpenCV's detectors need three corners each way; no printed board has more than this.
MIN_CORNERS, MAX_CORNERS = 3, 60


@dataclass(frozen=True)
class Board:
    """A chessboard of `columns` x `rows` inner corners, the points where black squares touch.

    The paper's "7-row and 10-column pattern" counts squares: 10x7 squares have 9x6 inner corners.

    The board's frame: x runs along the columns, y along the rows, the first corner is the origin, and z = x × y points
    into the board, away from the camera. Corner `row * columns + column` lies at
    `(column * square_mm, row * square_mm, 0)`.
    """

    columns: int
    rows: int
    square_mm: float

    @classmethod
    def parse(cls, text: str, square_mm: float) -> Board:
        """Return the board of a text such as "9x6", inner corners.

        Raises:
            InputError: the text or the size of a square makes no board.

        """
        columns, rows = columns_and_rows(text, "inner corners, such as 9x6 (a board of 10x7 squares)")
        check_square(square_mm)
        return cls(columns=columns, rows=rows, square_mm=square_mm)

    @property
    def n_corners(self) -> int:
        """Number of inner corners."""
        return self.columns * self.rows

    @property
    def points_mm(self) -> Array:
        """(N, 3) inner corners in the board frame, mm, row after row."""
        row, column = np.mgrid[0 : self.rows, 0 : self.columns]
        return np.stack([column.ravel(), row.ravel(), np.zeros(self.n_corners)], axis=1) * self.square_mm

    @property
    def told_by_colour(self) -> bool:
        """Whether half a turn swaps black and white, so that the first corner is told from the last by colour."""
        return (self.columns + self.rows) % 2 == 1

    @property
    def extent_mm(self) -> Array:
        """(2, 2) least and greatest x, y of the corners, mm."""
        return np.array([[0.0, 0.0], [self.columns - 1, self.rows - 1]]) * self.square_mm

    def find(self, name: str, image: Gray, window_px: int | None = None, thorough: bool = True) -> Corners | None:
        """Find all inner corners in a picture; None where they are not seen."""
        pixels = find_corners(image, self, window_px, thorough)
        return None if pixels is None else Corners(name, pixels)

    def points_of(self, view: Corners) -> Array:
        """(N, 3) board points of a view's pixels, mm."""
        return self.points_mm if view.ids is None else self.points_mm[view.ids]

    def y_down_px(self, view: Corners) -> float:
        """How far the board's y axis points down in the view, px."""
        return y_down_px(view.pixels.reshape(self.rows, self.columns, 2))

    def half_turned(self, views: Sequence[Corners]) -> tuple[Board, list[Corners]]:
        """Count the corners of all views from the other end."""
        return self, [Corners(view.name, view.pixels[::-1]) for view in views]

    def __str__(self) -> str:
        return f"{self.columns}x{self.rows} inner corners"


def columns_and_rows(text: str, counted: str) -> tuple[int, int]:
    """Columns and rows of a text such as "9x6".

    Raises:
        InputError: says that columns x rows of what is `counted` are wanted.

    """
    match = re.fullmatch(r"\s*(\d{1,4})\s*[x×X]\s*(\d{1,4})\s*", text)
    sizes = [int(n) for n in match.groups()] if match else []
    if not sizes or not all(MIN_CORNERS <= n <= MAX_CORNERS for n in sizes):
        raise InputError(
            f"--board: found {text!r}, wanted columns x rows of {counted}, each {MIN_CORNERS} to {MAX_CORNERS}"
        )
    return sizes[0], sizes[1]


def check_square(square_mm: float) -> None:
    """Refuse a side that no board has: below a millimetre metres were typed, above a metre something else was."""
    if not 1.0 <= square_mm <= 1000.0:
        raise InputError(f"--square-mm: found {square_mm:g}, wanted the side of a square in millimetres, 1 to 1000")
