"""Find a chessboard's inner corners in a picture, to sub-pixel accuracy and in one order for all pictures.

Order of the corners. Both of OpenCV's detectors give a grid in which x × y points away from the camera, but start at
either end of the board, as they please. Where half a turn swaps black and white (columns + rows odd, as 9x6), the first
corner is made the one beside a black corner square, whichever way the board is held; on other boards it is the one from
which y points up in the picture.
`calibrate_camera` then turns all views together so that y points up in the reference view, as in Table 2.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import cv2
import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from armtwin.calib.camera.board import Board

Array = NDArray[np.float64]
Gray = NDArray[np.uint8]

# The refinement's usual half window, px: OpenCV's calibration sample and most published intrinsics use it.
USUAL_WINDOW_PX = 11
# Boards are searched for in a picture of at most this many pixels a side: the detectors take seconds for a million
# pixels of clutter and minutes for twelve. The corners are then refined in the whole picture.
LARGEST_SEARCHED_PX = 1280
# An adapted half window reaches this share of the way to the nearest corner, so that it sees one corner only.
_WINDOW_SHARE = 0.4
_MIN_WINDOW_PX = 2
_REFINE = (cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS, 100, 1e-4)
# Contrast of a corner beyond the outermost found, as a share of the contrast inside, over which the board goes on.
# A corner in the board's rim has half of it (one side is white), a further inner corner all of it.
_GOES_ON = 0.75
# A step between neighbours may change by this share of itself from one to the next. Perspective and lenses stay below
# 0.3; a row of corners that was left out changes it by 0.67.
_STEP_CHANGE = 0.45


@dataclass(frozen=True, eq=False)
class Corners:
    """One view of the board.

    Attributes:
        name: for people.
        pixels: (N, 2) raw pixels.
        ids: (N,) which of the board's points they are; None for all of them in their order.
        radius_mm: of the circles of which the pixels are the outlines' centres; 0 for points.

    """

    name: str
    pixels: Array
    ids: NDArray[np.int_] | None = None
    radius_mm: float = 0.0


def find_corners(image: Gray, board: Board, window_px: int | None = None, thorough: bool = True) -> Array | None:
    """Return the (N, 2) inner corners, raw pixels, in the order of `Board.points_mm`, or None where they are not seen.

    `image` is (H, W) grey or (H, W, 3) BGR, uint8. `window_px` is the half window of the sub-pixel refinement; None
    adapts it to the view: at most `USUAL_WINDOW_PX`, and never near enough to a neighbour to mistake it for the corner.
    `thorough` asks a slow detector, which sees through blur and glare, where the quick one finds nothing.
    A board that goes on beyond the corners (a larger one) is not this board: None.
    """
    gray = np.asarray(cv2.cvtColor(image, cv2.COLOR_BGR2GRAY) if image.ndim == 3 else image, dtype=np.uint8)
    small, scale = reduced(gray)
    found = _detect(small, board, thorough)
    if found is None:
        return None
    grid = found.reshape(board.rows, board.columns, 2)
    if not _even(grid) or _goes_on(small, grid):
        return None
    grid = (_right_start(small, grid, board) + 0.5) * scale - 0.5
    half = window_px or min(window_limit_px(grid), int(USUAL_WINDOW_PX * scale.max()))
    return refine(gray, grid.reshape(-1, 2), half)


def reduced(gray: Gray) -> tuple[Gray, Array]:
    """Return the picture that a board is searched for in, and the (2,) size of its pixels, in pixels of `gray`."""
    height, width = gray.shape
    share = LARGEST_SEARCHED_PX / max(width, height)
    if share >= 1.0:
        return gray, np.ones(2)
    size = max(round(width * share), 1), max(round(height * share), 1)
    small = np.asarray(cv2.resize(gray, size, interpolation=cv2.INTER_AREA), dtype=np.uint8)
    return small, np.array([width, height]) / np.array(size)


def refine(gray: Gray, corners: Array, half: int) -> Array:
    """(N, 2) corners to sub-pixel accuracy, by a window of `half` pixels each way."""
    half = max(min(half, (min(gray.shape) - 6) // 2), 1)  # OpenCV wants the window well inside the picture
    start = corners.reshape(-1, 1, 2).astype(np.float32)
    return cv2.cornerSubPix(gray, start, (half, half), (-1, -1), _REFINE).reshape(-1, 2).astype(float)


def window_limit_px(grid: Array) -> int:
    """Largest half window, px, that sees one corner only, for a (rows, columns, 2) grid of corners."""
    return max(int(_WINDOW_SHARE * spacing_px(grid)), _MIN_WINDOW_PX)


def spacing_px(grid: Array) -> float:
    """Smallest distance of two neighbours in a (rows, columns, 2) grid of corners, px."""
    along, across = (np.linalg.norm(np.diff(grid, axis=axis), axis=-1).min() for axis in (0, 1))
    return float(min(along, across))


def _detect(gray: Gray, board: Board, thorough: bool) -> Array | None:
    """Try the quick detector, then the thorough one (Duda and Frese 2018)."""
    size = (board.columns, board.rows)
    seen, corners = cv2.findChessboardCorners(gray, size)
    if not seen and thorough:
        flags = cv2.CALIB_CB_EXHAUSTIVE | cv2.CALIB_CB_ACCURACY | cv2.CALIB_CB_NORMALIZE_IMAGE
        seen, corners = cv2.findChessboardCornersSB(gray, size, flags=flags)
    return corners.reshape(-1, 2).astype(float) if seen else None


def _right_start(gray: Gray, grid: Array, board: Board) -> Array:
    if board.told_by_colour:
        rows, columns = board.rows, board.columns
        middles = _sample(gray, grid, np.mgrid[0 : columns - 1, 0 : rows - 1].reshape(2, -1).T + 0.5)
        parity = np.add(*np.mgrid[0 : columns - 1, 0 : rows - 1]).ravel() % 2
        # The corner square lies diagonally outside the first corner, of one colour with the first square inside.
        return grid if np.nanmean(middles[parity == 0]) < np.nanmean(middles[parity == 1]) else grid[::-1, ::-1]
    turns = [grid, grid[::-1, ::-1]]
    if board.columns == board.rows:
        turns += [np.rot90(grid), np.rot90(grid, -1)]
    return min(turns, key=y_down_px)


def y_down_px(grid: Array) -> float:
    """How far the board's y axis points down in the picture, px, for a (rows, columns, 2) grid of corners."""
    return float((grid[-1] - grid[0])[:, 1].mean())


def _even(grid: Array) -> bool:
    """Whether the steps from corner to corner change slowly, so that none was left out."""
    for axis in (0, 1):
        steps = np.diff(grid, axis=axis)
        change = np.linalg.norm(np.diff(steps, axis=axis), axis=-1)
        step = np.linalg.norm(steps, axis=-1)
        mean = (np.delete(step, 0, axis) + np.delete(step, -1, axis)) / 2.0
        if np.any(change > _STEP_CHANGE * mean):
            return False
    return True


def _goes_on(gray: Gray, grid: Array) -> bool:
    """Whether a whole further row or column of corners lies beside the grid."""
    rows, columns = grid.shape[:2]
    inside = np.abs(_saddle(gray, grid, np.mgrid[0:columns, 0:rows].reshape(2, -1).T))
    typical = float(np.nanmedian(inside))
    sides = [
        [(-1, j) for j in range(rows)],
        [(columns, j) for j in range(rows)],
        [(i, -1) for i in range(columns)],
        [(i, rows) for i in range(columns)],
    ]
    for side in sides:
        contrast = np.abs(_saddle(gray, grid, np.array(side)))
        if np.all(np.isfinite(contrast)) and np.median(contrast) > _GOES_ON * typical:
            return True
    return False


def _saddle(gray: Gray, grid: Array, at: Array) -> Array:
    """Contrast of the (N, 2) grid positions as corners: one diagonal pair of squares against the other, grey levels."""
    # A quarter square away: boards whose outermost squares are cut in half are common.
    a, b, c, d = (_sample(gray, grid, at + 0.25 * np.array(step)) for step in ((-1, -1), (1, 1), (-1, 1), (1, -1)))
    return (a + b - c - d) / 2.0


def _sample(gray: Gray, grid: Array, at: Array) -> Array:
    """Grey level at (N, 2) positions in grid units (column, row), NaN outside the picture."""
    rows, columns = grid.shape[:2]
    units = np.mgrid[0:columns, 0:rows].T.reshape(-1, 2).astype(float)
    H, _ = cv2.findHomography(units, grid.reshape(-1, 2))
    pixels = cv2.perspectiveTransform(at.reshape(-1, 1, 2).astype(float), H).reshape(-1, 2)
    column, row = np.rint(pixels).astype(int).T
    inside = (column >= 0) & (row >= 0) & (column < gray.shape[1]) & (row < gray.shape[0])
    levels = np.full(len(pixels), np.nan)
    levels[inside] = gray[row[inside], column[inside]]
    return levels
