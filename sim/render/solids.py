"""Solids as meshes fine enough for the lens, in mm."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import trimesh
from numpy.typing import NDArray

Array = NDArray[np.float64]

# A straight edge of this length departs from its distorted image by at most 0.014 px in Table 2's picture; the
# departure grows with the square of the length.
EDGE_MM = 4.0


def translation(x_mm: float, y_mm: float, z_mm: float) -> Array:
    """(4, 4) transform that moves by the given lengths."""
    T = np.eye(4)
    T[:3, 3] = x_mm, y_mm, z_mm
    return T


def grid(x_mm: Array, y_mm: Array, z_mm: float = 0.0) -> trimesh.Trimesh:
    """Mesh the rectangle spanned by ascending coordinates, seen from -z (its normal is -z)."""
    nx, ny = len(x_mm), len(y_mm)
    x, y = np.meshgrid(x_mm, y_mm, indexing="ij")
    vertices = np.stack([x.ravel(), y.ravel(), np.full(nx * ny, z_mm)], axis=1)
    i, j = (a.ravel() for a in np.meshgrid(np.arange(nx - 1), np.arange(ny - 1), indexing="ij"))
    corner = i * ny + j
    faces = np.concatenate(
        [
            np.stack([corner, corner + 1, corner + ny], axis=1),
            np.stack([corner + 1, corner + ny + 1, corner + ny], axis=1),
        ]
    )
    return trimesh.Trimesh(vertices, faces, process=False)


def joined(meshes: Sequence[trimesh.Trimesh]) -> trimesh.Trimesh:
    """Put meshes into one, vertices in the order given."""
    firsts = np.cumsum([0, *(len(m.vertices) for m in meshes[:-1])])
    faces = np.vstack([m.faces + first for m, first in zip(meshes, firsts, strict=True)])
    return trimesh.Trimesh(np.vstack([m.vertices for m in meshes]), faces, process=False)


def steps(start_mm: float, end_mm: float, longest_mm: float = EDGE_MM) -> Array:
    """Divide a length evenly into steps no longer than `longest_mm`."""
    return np.linspace(start_mm, end_mm, max(1, int(np.ceil((end_mm - start_mm) / longest_mm))) + 1)


def box(low_mm: Sequence[float], high_mm: Sequence[float], longest_mm: float = EDGE_MM) -> trimesh.Trimesh:
    """Mesh the box between two corners."""
    (x0, y0, z0), (x1, y1, z1) = low_mm, high_mm
    return extrusion(np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]]), z0, z1, longest_mm)


def plate(low_mm: Sequence[float], high_mm: Sequence[float], longest_mm: float = EDGE_MM) -> trimesh.Trimesh:
    """Mesh the box between two corners with faces that are divided all over.

    A wide face of long triangles, tilted, stands out of its plane by millimetres once the lens has bent their corners,
    and hides what lies on it; here it does not.
    """
    low, high = np.asarray(low_mm, dtype=float), np.asarray(high_mm, dtype=float)
    sides = []
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        side = grid(steps(low[u], high[u], longest_mm), steps(low[v], high[v], longest_mm))
        for level, faces in ((low[axis], side.faces), (high[axis], side.faces[:, ::-1])):
            vertices = np.empty_like(side.vertices)
            vertices[:, u], vertices[:, v] = side.vertices[:, 0], side.vertices[:, 1]
            vertices[:, axis] = level
            sides.append(trimesh.Trimesh(vertices, faces, process=False))
    return joined(sides)


def extrusion(outline_mm: Array, z_low_mm: float, z_high_mm: float, longest_mm: float = EDGE_MM) -> trimesh.Trimesh:
    """Mesh the prism over a convex outline, (N, 2) counter-clockwise, between two heights.

    Only the rims are divided finely: inside a narrow face of one colour nothing shows how the lens bends it, and each
    triangle costs time. Upright edges are seen almost end on and are divided every 12 mm.
    """
    rim = _resample(outline_mm, longest_mm)
    n = len(rim)
    layers = [np.column_stack([rim, np.full(n, z)]) for z in steps(z_low_mm, z_high_mm, 3.0 * longest_mm)]
    k = np.arange(n)
    k1 = (k + 1) % n
    faces = [_convex(n)[:, ::-1], _convex(n) + n * (len(layers) - 1)]
    for layer in range(len(layers) - 1):
        a, b = layer * n, (layer + 1) * n
        faces += [np.stack([a + k, a + k1, b + k], axis=1), np.stack([a + k1, b + k1, b + k], axis=1)]
    return trimesh.Trimesh(np.vstack(layers), np.vstack(faces), process=False)


def _convex(n: int) -> NDArray[np.int64]:
    """(n - 2, 3) counter-clockwise triangles of a convex polygon, in zigzag from its first side to the opposite one."""
    faces: list[tuple[int, int, int]] = []
    i, j = 0, n - 1
    while j - i > 1:
        if len(faces) % 2 == 0:
            faces.append((i, i + 1, j))
            i += 1
        else:
            faces.append((i, j - 1, j))
            j -= 1
    return np.array(faces)


def circle(radius_mm: float, sections: int = 48) -> Array:
    """(sections, 2) counter-clockwise outline of a circle."""
    angle = np.linspace(0.0, 2.0 * np.pi, sections, endpoint=False)
    return radius_mm * np.stack([np.cos(angle), np.sin(angle)], axis=1)


def bar(length_mm: float, width_mm: float, sections: int = 32) -> Array:
    """(sections, 2) counter-clockwise outline of a bar from (0, 0) to (length, 0) with round ends."""
    angle = np.linspace(-0.5 * np.pi, 0.5 * np.pi, sections // 2)
    cap = 0.5 * width_mm * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return np.vstack([cap + np.array([length_mm, 0.0]), -cap])


def _resample(outline_mm: Array, longest_mm: float) -> Array:
    pieces = []
    for start, end in zip(outline_mm, np.roll(outline_mm, -1, axis=0), strict=True):
        count = max(1, int(np.ceil(np.linalg.norm(end - start) / longest_mm)))
        pieces.append(start + np.linspace(0.0, 1.0, count, endpoint=False)[:, None] * (end - start))
    return np.vstack(pieces)
