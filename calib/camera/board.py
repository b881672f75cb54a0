"""The chessboard: its inner corners, their order and the frame that they span."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armtwin.models.errors import InputError

Array = NDArray[np.float64]

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
        match = re.fullmatch(r"\s*(\d{1,4})\s*[x×X]\s*(\d{1,4})\s*", text)
        sizes = [int(n) for n in match.groups()] if match else []
        if not sizes or not all(MIN_CORNERS <= n <= MAX_CORNERS for n in sizes):
            raise InputError(
                f"--board: found {text!r}, wanted columns x rows of inner corners, each {MIN_CORNERS} to "
                f"{MAX_CORNERS}, such as 9x6 (a board of 10x7 squares)"
            )
        # Squares below a millimetre mean that metres were typed; above a metre, that something else was.
        if not 1.0 <= square_mm <= 1000.0:
            raise InputError(f"--square-mm: found {square_mm:g}, wanted the side of a square in millimetres, 1 to 1000")
        return cls(columns=sizes[0], rows=sizes[1], square_mm=square_mm)

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

    def __str__(self) -> str:
        return f"{self.columns}x{self.rows} inner corners"
