"""Parts of a scene: a solid, its paint, the body that carries it, and what is printed on it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import trimesh
from numpy.typing import NDArray

from armtwin.models.errors import InputError

Array = NDArray[np.float64]
Colour = tuple[float, float, float]  # red, green, blue reflectance, linear, 0 to 1


@dataclass(frozen=True, eq=False)
class Ink:
    """A second colour printed on a part, bounded by edges that are drawn exactly rather than by the mesh.

    A point is inked where the product of its two signed distances is positive: one distance and a large constant make
    a disc or a half plane, two make a corner of a chessboard.

    Attributes:
        colour: reflectance.
        edges_mm: (V, 2) signed distances of the mesh's vertices to the two edges, interpolated linearly over a face.

    """

    colour: Colour
    edges_mm: Array


@dataclass(frozen=True, eq=False)
class Part:
    """A solid of one colour.

    Attributes:
        name: for messages.
        mesh: vertices in mm in the frame of `body`; edges longer than about 4 mm bend visibly wrong in the lens.
        colour: reflectance.
        body: the body that carries it, whose pose the renderer is given; None for a part fixed in the board frame.
        ink: what is printed on it.
        backdrop: a part behind all others, fixed in the board frame and square to its z axis, on which their shadows
            fall. It hides nothing, whatever its depth: only so can things lie on it when the lens bends large faces.

    """

    name: str
    mesh: trimesh.Trimesh
    colour: Colour
    body: str | None = None
    ink: Ink | None = None
    backdrop: bool = False

    def __post_init__(self) -> None:
        if self.backdrop and (self.body is not None or self.ink is not None):
            raise InputError(f"part {self.name!r} is a backdrop, which neither moves nor is printed on")

    def on(self, body: str | None, T_body_part: Array | None = None) -> Part:
        """Return the part carried by `body`, moved by the (4, 4) transform `T_body_part` (mm)."""
        if T_body_part is None:
            return replace(self, body=body)
        vertices = self.mesh.vertices @ T_body_part[:3, :3].T + T_body_part[:3, 3]
        return replace(self, mesh=trimesh.Trimesh(vertices, self.mesh.faces, process=False), body=body)


@dataclass(frozen=True, eq=False)
class Buffers:
    """Merged vertices of several parts, each with one row a vertex, ready for one draw call.

    Attributes:
        positions, normals: (V, 3) in body frames, mm.
        body: (V,) index of the body.
        paint: (V, 3) blue, green, red.
        ink: (V, 3) blue, green, red, and `edges` (V, 2) mm; None for parts with nothing printed on them.
        faces: (F, 3) rows of vertices.

    """

    positions: Array
    normals: Array
    body: Array
    paint: Array
    faces: NDArray[np.int64]
    ink: Array | None = None
    edges: Array | None = None


def merge(parts: Sequence[Part], body_index: dict[str | None, int]) -> Buffers | None:
    """Merge parts that are all printed on, or all not; None for no parts.

    Every face keeps its own normal: vertices are shared between faces of one plane only.
    """
    if not parts:
        return None
    tables, faces, first = [], [], 0
    for part in parts:
        corners = part.mesh.faces.reshape(-1)
        columns = [
            part.mesh.vertices[corners],
            np.repeat(part.mesh.face_normals, 3, axis=0).round(6),
            np.full((corners.size, 1), float(body_index[part.body])),
            np.tile(part.colour[::-1], (corners.size, 1)),
        ]
        if part.ink is not None:
            columns += [np.tile(part.ink.colour[::-1], (corners.size, 1)), part.ink.edges_mm[corners]]
        rows, index = np.unique(np.hstack(columns), axis=0, return_inverse=True)
        tables.append(rows)
        faces.append(index.reshape(-1, 3) + first)
        first += len(rows)
    table = np.vstack(tables)
    printed = table.shape[1] > 10
    return Buffers(
        positions=table[:, 0:3],
        normals=table[:, 3:6],
        body=table[:, 6],
        paint=table[:, 7:10],
        faces=np.vstack(faces),
        ink=table[:, 10:13] if printed else None,
        edges=table[:, 13:15] if printed else None,
    )
