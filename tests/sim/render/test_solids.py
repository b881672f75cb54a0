"""Solids are closed, look outwards and are fine enough for the lens."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from armtwin.sim.render.solids import EDGE_MM, bar, box, circle, extrusion, plate
from armtwin.sim.render.stickers import chessboard, disc

SOLIDS = {
    "box": (box((-10.0, -20.0, -30.0), (40.0, 10.0, 5.0)), 50.0 * 30.0 * 35.0),
    "plate": (plate((-10.0, -20.0, -30.0), (40.0, 10.0, 5.0)), 50.0 * 30.0 * 35.0),
    "bar": (extrusion(bar(100.0, 14.0), 0.0, 6.0), None),
    "cylinder": (extrusion(circle(10.0), -3.0, 4.0), None),
}


@pytest.mark.parametrize("name", SOLIDS)
def test_solids_are_closed_and_face_outwards(name: str) -> None:
    mesh, volume = SOLIDS[name]
    merged = trimesh.Trimesh(mesh.vertices, mesh.faces)
    assert merged.is_watertight
    assert merged.is_winding_consistent
    assert merged.volume == pytest.approx(volume, rel=1e-9) if volume else merged.volume > 0.0


@pytest.mark.parametrize("name", ["box", "bar", "cylinder"])
def test_the_rim_of_a_solid_is_divided_finely(name: str) -> None:
    mesh, _ = SOLIDS[name]
    top = mesh.vertices[:, 2].max()
    rim = mesh.facets_boundary[int(np.argmax(mesh.facets_normal[:, 2]))]
    ends = mesh.vertices[rim]
    assert np.all(ends[..., 2] == top)
    assert np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).max() <= EDGE_MM + 1e-9


def test_a_discs_polygon_has_the_circles_area() -> None:
    part = disc("disc", 7.0, 10.5)
    assert part.ink is not None
    inside = part.ink.edges_mm[:, 0] >= 0.0
    face = inside[part.mesh.faces].all(axis=1)
    assert part.mesh.area_faces[face].sum() == pytest.approx(np.pi * 49.0, rel=1e-9)
    assert np.all(part.mesh.face_normals[:, 2] > 0.99)


def test_a_chessboard_looks_along_minus_z_and_has_its_margin() -> None:
    mesh = chessboard("board", 10, 7, 23.0, 15.0).mesh
    assert np.all(mesh.face_normals[:, 2] < -0.99)
    assert mesh.bounds[:, :2] == pytest.approx(np.array([[-38.0, -38.0], [222.0, 153.0]]))
    assert mesh.area == pytest.approx(260.0 * 191.0)
