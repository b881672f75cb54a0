"""Printed targets: discs and the chessboard, their edges drawn exactly; faces look along +z of their own frame."""

from __future__ import annotations

import numpy as np
import trimesh
from numpy.typing import NDArray

from armtwin.sim.render.parts import Colour, Ink, Part
from armtwin.sim.render.solids import EDGE_MM, circle, grid, joined, steps

Array = NDArray[np.float64]

# Reflectances, linear. The red channel sees red ink almost as white paper and black ink as dark: the contrast between
# disc and ground is 0.72 in red, 0.02 in green and blue.
RED: Colour = (0.75, 0.045, 0.04)
BLACK: Colour = (0.030, 0.030, 0.032)
WHITE: Colour = (0.80, 0.80, 0.78)

# Never reached by the ramp across an edge, so that one distance alone decides.
_FAR_MM = 1e3
_SECTIONS = 96


def disc(
    name: str,
    radius_mm: float,
    ground_radius_mm: float,
    centre_mm: tuple[float, float, float] = (0.0, 0.0, 0.0),
    colours: tuple[Colour, Colour] = (RED, BLACK),
) -> Part:
    """Draw a disc of `colours[0]` on a round ground of `colours[1]`, in the plane z = centre z.

    The edge is a polygon of 96 sides with the circle's area (its corners lie 0.07 % outside, its sides as much inside).
    """
    half_angle = np.pi / _SECTIONS
    polygon = radius_mm * np.sqrt(2.0 * half_angle / np.sin(2.0 * half_angle))
    ring = min(0.1 * radius_mm, 0.5 * (ground_radius_mm - polygon))  # the ramp needs its distances near the edge only
    radii = np.array([ground_radius_mm, polygon + ring, polygon, polygon - ring])
    vertices = np.vstack(
        [*(np.column_stack([circle(r, _SECTIONS), np.zeros(_SECTIONS)]) for r in radii), np.zeros((1, 3))]
    )
    k = np.arange(_SECTIONS)
    k1 = (k + 1) % _SECTIONS
    faces = []
    for layer in range(len(radii) - 1):
        a, b = layer * _SECTIONS, (layer + 1) * _SECTIONS
        faces += [np.stack([a + k, a + k1, b + k], axis=1), np.stack([a + k1, b + k1, b + k], axis=1)]
    last = (len(radii) - 1) * _SECTIONS
    faces.append(np.stack([last + k, last + k1, np.full(_SECTIONS, len(vertices) - 1)], axis=1))
    distance = np.append(np.repeat(polygon - radii, _SECTIONS), polygon)
    mesh = trimesh.Trimesh(vertices + np.asarray(centre_mm), np.vstack(faces), process=False)
    edges = np.column_stack([distance, np.full(len(vertices), _FAR_MM)])
    return Part(name, mesh, colours[1], ink=Ink(colours[0], edges))


def chessboard(
    name: str,
    columns: int,
    rows: int,
    square_mm: float,
    margin_mm: float,
    colours: tuple[Colour, Colour] = (BLACK, WHITE),
) -> Part:
    """Draw a chessboard of `columns` x `rows` squares and its margin in the plane z = 0, seen from -z.

    The frame is OpenCV's: the origin is the first inner corner, x along the columns, y along the rows, z away from the
    one who looks. The square before the origin, with negative x and y, has `colours[0]`; the margin has `colours[1]`.
    """
    meshes, edges = [], []

    def rectangle(x0: float, x1: float, y0: float, y1: float) -> Array:
        mesh = grid(steps(x0, x1, EDGE_MM), steps(y0, y1, EDGE_MM))
        meshes.append(mesh)
        corners: Array = mesh.vertices[:, :2]
        return corners

    x = square_mm * np.array([-1.0, *(np.arange(1, columns - 1) - 0.5), columns - 1.0])
    y = square_mm * np.array([-1.0, *(np.arange(1, rows - 1) - 0.5), rows - 1.0])
    for i in range(columns - 1):
        for j in range(rows - 1):
            corners = rectangle(x[i], x[i + 1], y[j], y[j + 1])
            sign = 1.0 if (i + j) % 2 == 0 else -1.0
            edges.append((corners - square_mm * np.array([i, j])) * [sign, 1.0])
    left, right, top, bottom = x[0] - margin_mm, x[-1] + margin_mm, y[0] - margin_mm, y[-1] + margin_mm
    for sides in (
        (left, right, top, y[0]),
        (left, right, y[-1], bottom),
        (left, x[0], y[0], y[-1]),
        (x[-1], right, y[0], y[-1]),
    ):
        edges.append(np.tile([_FAR_MM, -_FAR_MM], (len(rectangle(*sides)), 1)))
    return Part(name, joined(meshes), colours[1], ink=Ink(colours[0], np.vstack(edges)))
