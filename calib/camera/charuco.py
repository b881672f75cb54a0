"""ChArUco boards: chessboard corners told apart by markers, so that a view may show a part of the board."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
from numpy.typing import NDArray

from armtwin.calib.camera.board import check_square, columns_and_rows
from armtwin.calib.camera.corners import USUAL_WINDOW_PX, Corners, reduced, refine
from armtwin.models.errors import InputError, nearest

Array = NDArray[np.float64]
Gray = NDArray[np.uint8]

# Fewer corners than this tell too little of a pose beside a lens.
_LEAST_CORNERS = 8
# Fewer markers are seen by chance in clutter.
_LEAST_MARKERS = 4
# Makers print markers of three quarters of a square where they say nothing else; the corners hardly feel it.
USUAL_MARKER_SHARE = 0.75
DICTIONARIES = {
    name.removeprefix("DICT_").lower(): getattr(cv2.aruco, name)
    for name in sorted(dir(cv2.aruco))
    if name.startswith("DICT_") and "APRILTAG" not in name and "ORIGINAL" not in name
}


@dataclass(frozen=True)
class CharucoTarget:
    """A ChArUco board of `columns` x `rows` squares, as its makers count.

    Its frame's origin is the first inner corner, and it turns with the board: markers tell which end is which.
    """

    columns: int
    rows: int
    square_mm: float
    dictionary: str
    marker_share: float = USUAL_MARKER_SHARE

    @classmethod
    def parse(cls, text: str, square_mm: float, dictionary: str, marker_mm: float | None = None) -> CharucoTarget:
        """Return the board of a text such as "8x11", squares.

        Raises:
            InputError: these make no board.

        """
        columns, rows = columns_and_rows(text, "squares of a ChArUco board, such as 8x11")
        check_square(square_mm)
        if dictionary not in DICTIONARIES:
            near = nearest(dictionary, DICTIONARIES)
            raise InputError(f"--dictionary: found {dictionary!r}, wanted the markers' dictionary{near}")
        share = USUAL_MARKER_SHARE if marker_mm is None else marker_mm / square_mm
        if not 0.1 <= share < 1.0:
            raise InputError(f"--marker-mm: found {marker_mm:g}, wanted the side of a marker, below {square_mm:g}")
        return cls(columns, rows, square_mm, dictionary, share)

    @property
    def n_corners(self) -> int:
        """Number of inner corners."""
        return (self.columns - 1) * (self.rows - 1)

    @property
    def points_mm(self) -> Array:
        """(N, 3) inner corners, mm, row after row, from the first."""
        row, column = np.mgrid[0 : self.rows - 1, 0 : self.columns - 1]
        return np.stack([column.ravel(), row.ravel(), np.zeros(self.n_corners)], axis=1) * self.square_mm

    @property
    def extent_mm(self) -> Array:
        """(2, 2) least and greatest x, y of the corners, mm."""
        return np.array([[0.0, 0.0], [self.columns - 2, self.rows - 2]]) * self.square_mm

    def find(self, name: str, image: Gray, window_px: int | None = None, thorough: bool = True) -> Corners | None:
        """Find the inner corners that are seen; None where there are fewer than eight."""
        small, scale = reduced(image)
        for legacy in (False, True):
            found, ids, _, _ = self._detectors[legacy].detectBoard(small)
            if ids is not None and len(ids) >= _LEAST_CORNERS:
                break
        else:
            return None
        ids = np.asarray(ids, dtype=int).ravel()
        corners = (np.asarray(found, dtype=float).reshape(-1, 2) + 0.5) * scale - 0.5
        # Within the white around the markers, whose own corners are no corners of squares.
        clear = int(0.5 * (1.0 - self.marker_share) * _spacing_px(corners))
        half = window_px or min(clear, int(USUAL_WINDOW_PX * scale.max()))
        return Corners(name, refine(image, corners, max(half, 2)), np.asarray(ids, dtype=np.int_))

    def points_of(self, view: Corners) -> Array:
        """(N, 3) board points of a view's pixels, mm."""
        return self.points_mm if view.ids is None else self.points_mm[view.ids]

    def y_down_px(self, view: Corners) -> float:
        """How far the board's y axis points down in the view, px."""
        return y_slope_px(self.points_of(view), view.pixels)

    def half_turned(self, views: Sequence[Corners]) -> tuple[CharucoTarget, list[Corners]]:
        """Count the corners of all views from the other end."""
        last = self.n_corners - 1
        return self, [Corners(v.name, v.pixels, None if v.ids is None else last - v.ids) for v in views]

    def __str__(self) -> str:
        """What it is, for people."""
        return f"a ChArUco board of {self.columns}x{self.rows} squares ({self.dictionary})"

    @cached_property
    def _detectors(self) -> dict[bool, cv2.aruco.CharucoDetector]:
        """Of the pattern, and of the one that OpenCV before 4.6 made of an even number of rows."""
        markers = cv2.aruco.getPredefinedDictionary(DICTIONARIES[self.dictionary])
        size, share = (self.columns, self.rows), self.marker_share
        detectors = {}
        for legacy in (False, True):
            board = cv2.aruco.CharucoBoard(size, self.square_mm, share * self.square_mm, markers)
            board.setLegacyPattern(legacy)
            detectors[legacy] = cv2.aruco.CharucoDetector(board)
        return detectors


def dictionary_seen(image: Gray) -> str | None:
    """Name the smallest dictionary of markers of which a picture shows several; None where it shows none."""
    small, _ = reduced(image)
    best = (_LEAST_MARKERS - 1, -1, "")
    for name, number in DICTIONARIES.items():
        if not name.endswith("_1000"):
            continue  # the smaller ones are its first markers
        detector = cv2.aruco.ArucoDetector(cv2.aruco.getPredefinedDictionary(number))
        _, ids, _ = detector.detectMarkers(small)
        if ids is not None and len(ids) > best[0]:
            best = (len(ids), int(np.max(ids)), name)
    if not best[2]:
        return None
    sizes = [size for size in (50, 100, 250, 1000) if best[1] < size]
    return f"{best[2].removesuffix('_1000')}_{sizes[0]}"


def y_slope_px(points: Array, pixels: Array) -> float:
    """By how much a picture's v grows over the extent of a board's y, from (N, 3) points and (N, 2) pixels."""
    y = points[:, 1] - points[:, 1].mean()
    x = points[:, 0] - points[:, 0].mean()
    slope = np.linalg.lstsq(np.stack([x, y], axis=1), pixels[:, 1] - pixels[:, 1].mean(), rcond=None)[0]
    return float(slope[1] * np.ptp(y))


def _spacing_px(corners: Array) -> float:
    """Smallest distance between two of (N, 2) corners, px."""
    away = np.linalg.norm(corners[:, None] - corners[None], axis=-1)
    np.fill_diagonal(away, np.inf)
    return float(away.min())
