"""Which pixels a set of moving bodies can cover."""

from __future__ import annotations

import itertools

import numpy as np
import trimesh
from numpy.typing import NDArray

from armtwin.models.camera import Camera, corner_angle_rad, in_camera, project
from armtwin.sim.render.solids import steps

Array = NDArray[np.float64]

# Between two points 15 mm apart on a straight edge the lens bends the edge by at most 0.2 px (0.014 px at 4 mm, growing
# with the square); one more pixel for the samples' width.
_SPACING_MM = 15.0
_MARGIN_PX = 2


def outline(mesh: trimesh.Trimesh) -> Array:
    """(N, 3) points, mm, along the edges of the box around a mesh, close enough that the lens cannot hide a bulge."""
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    points = []
    for axis in range(3):
        along = steps(low[axis], high[axis], _SPACING_MM)
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for a, b in itertools.product((low[u], high[u]), (low[v], high[v])):
            edge = np.empty((len(along), 3))
            edge[:, axis], edge[:, u], edge[:, v] = along, a, b
            points.append(edge)
    return np.unique(np.vstack(points), axis=0)


def covered_box(camera: Camera, points_board_mm: Array) -> tuple[int, int, int, int]:
    """Bound the projections of (N, 3) points: u0, v0, u1, v1 in whole pixels inside the picture, end exclusive.

    The whole picture where a point lies so far out that the lens folds, or much farther than the picture's corners.
    """
    whole = (0, 0, camera.image_width, camera.image_height)
    X = in_camera(camera, points_board_mm)
    angle = np.arctan2(np.hypot(X[:, 0], X[:, 1]), X[:, 2]).max()
    if not angle < min(2.0 * corner_angle_rad(camera), camera.lens.limit_rad):
        return whole
    pixels = project(camera, points_board_mm)
    low = np.floor(pixels.min(axis=0)).astype(int) - _MARGIN_PX
    high = np.ceil(pixels.max(axis=0)).astype(int) + 1 + _MARGIN_PX
    u0, v0 = np.clip(low, 0, whole[2:])
    u1, v1 = np.clip(high, 0, whole[2:])
    return int(u0), int(v0), int(u1), int(v1)
