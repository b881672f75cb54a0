"""Grids of circles, symmetric or not: OpenCV's detector tells them apart, the markers' measures them.

What is measured is the centre of a circle's picture, which tilt and lens move off the picture of the circle's centre,
by tenths of a pixel where circles are large (OpenCV's issue 7312). How far follows from their size, which is measured,
and from the camera: `centred` takes it off once there is a first fit.
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
from armtwin.calib.camera.fit import CameraCalibration
from armtwin.calib.markers.disc import DetectorConfig, Disc
from armtwin.calib.markers.subpixel import detect_subpixel
from armtwin.models.camera import project

Array = NDArray[np.float64]
Gray = NDArray[np.uint8]


# Blobs beside the grid's own: with more, OpenCV's search for a grid in them takes a second and soon minutes.
_MOST_BLOBS = 300
# Points of a circle that its picture is computed from.
_RIM_POINTS = 90


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
        if len(cv2.SimpleBlobDetector.create().detect(small)) > _MOST_BLOBS + 2 * self.n_corners:
            return None
        size = (self.columns, self.rows)
        kind = cv2.CALIB_CB_ASYMMETRIC_GRID if self.staggered else cv2.CALIB_CB_SYMMETRIC_GRID
        for flags in (kind, kind | cv2.CALIB_CB_CLUSTERING):
            seen, centres = cv2.findCirclesGrid(small, size, flags=flags)
            if seen:
                places = (np.asarray(centres, dtype=float).reshape(-1, 2) + 0.5) * scale - 0.5
                return self._measured(name, image, self._right_handed(places))
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

    def _measured(self, name: str, image: Gray, places: Array) -> Corners:
        """Centres of the circles' outlines where the markers' detector sees them, else as they were found."""
        discs = _discs(image, places)
        pixels = np.array([place if disc is None else disc.centre for place, disc in zip(places, discs, strict=True)])
        H, _ = cv2.findHomography(self.points_mm[:, :2], pixels)
        radii = []
        for point, disc in zip(self.points_mm, discs, strict=True):
            if disc is not None:
                area = abs(np.linalg.det(H) / float(H[2] @ [*point[:2], 1.0]) ** 3)  # px^2 of a mm^2 there
                radii.append(np.sqrt(np.prod(disc.axes) / area))
        return Corners(name, pixels, radius_mm=float(np.median(radii)) if radii else 0.0)


def centred(fit: CameraCalibration) -> tuple[Corners, ...]:
    """Return the views of a first fit with the circles' own centres instead of their pictures'."""
    angle = np.linspace(0.0, 2.0 * np.pi, _RIM_POINTS, endpoint=False)
    rim = np.stack([np.cos(angle), np.sin(angle), np.zeros(_RIM_POINTS)], axis=1)
    views = []
    for view, pose in zip(fit.views, fit.poses, strict=True):
        camera = replace(fit.camera, R_board_camera=cv2.Rodrigues(pose[:3])[0], t_board_camera_mm=pose[3:])
        points = fit.board.points_of(view)
        outline = project(camera, points[:, None] + view.radius_mm * rim)
        pixels = view.pixels - (_centroids(outline) - project(camera, points))
        views.append(replace(view, pixels=pixels))
    return tuple(views)


def _centroids(outlines: Array) -> Array:
    """(N, 2) centroids of the areas within (N, M, 2) outlines (Green's theorem); of a point, the point."""
    origin = outlines.mean(axis=1)
    p = outlines - origin[:, None]
    q = np.roll(p, -1, axis=1)
    cross = p[..., 0] * q[..., 1] - p[..., 1] * q[..., 0]
    area = 3.0 * cross.sum(axis=1)
    moment = ((p + q) * cross[..., None]).sum(axis=1)
    return np.where(np.abs(area)[:, None] > 1e-12, origin + moment / np.where(area == 0.0, 1.0, area)[:, None], origin)


def _discs(image: Gray, places: Array) -> list[Disc | None]:
    """The dark disc at each of (N, 2) places, None where none is seen whole."""
    away = np.linalg.norm(places[:, None] - places[None], axis=-1)
    np.fill_diagonal(away, np.inf)
    spacing = float(away.min())
    config = DetectorConfig(min_radius_px=3.0, max_radius_px=max(0.6 * float(np.median(away.min(axis=1))), 4.0))
    discs = [disc for disc in detect_subpixel(255 - image, None, 0.0, config) if disc.is_whole]
    if not discs:
        return [None] * len(places)
    centres = np.array([disc.centre for disc in discs])
    nearest = np.linalg.norm(places[:, None] - centres[None], axis=-1)
    best = nearest.argmin(axis=1)
    return [discs[k] if nearest[i, k] < 0.3 * spacing else None for i, k in enumerate(best)]
