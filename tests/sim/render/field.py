"""Discs over the whole picture, and where their images lie by geometry alone."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from armtwin.models.camera import Camera, back_project, project, project_jacobian
from armtwin.sim.render import Part, disc

Array = NDArray[np.float64]

RADIUS_PX, GROUND_PX = 15.0, 22.0


def pixel_grid(camera: Camera, columns: int = 25, rows: int = 14) -> Array:
    """(columns * rows, 2) pixels; the outermost discs all but touch the picture's border. Spaced unevenly by fractions
    of a pixel, so that every place within a pixel is tried."""
    margin = RADIUS_PX + 3.0
    u = np.linspace(margin, camera.image_width - 1 - margin, columns)
    v = np.linspace(margin, camera.image_height - 1 - margin, rows)
    return np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2)


def disc_field(camera: Camera, pixels: Array) -> tuple[list[Part], Array, Array]:
    """Discs in the plane z_board = 0 whose centres project to `pixels`: the parts, (N, 3) centres mm, (N,) radii mm.

    The longest half axis of each disc's image is RADIUS_PX.
    """
    centres = back_project(camera, pixels, 0.0)
    stretch = np.linalg.svd(project_jacobian(camera, centres)[..., :2], compute_uv=False)[:, 0]
    mm_per_px = 1.0 / stretch
    parts = []
    for k, (centre, scale) in enumerate(zip(centres, mm_per_px, strict=True)):
        T = np.diag([1.0, -1.0, -1.0, 1.0])
        T[:3, 3] = centre
        parts.append(disc(f"disc {k}", RADIUS_PX * scale, GROUND_PX * scale).on(None, T))
    return parts, centres, RADIUS_PX * mm_per_px


def image_centroid(camera: Camera, centre_mm: Array, radius_mm: float) -> Array:
    """(2,) centroid of the area that a disc of the plane z = const covers in the picture.

    The centre of a circle does not project to the centre of its image, so the rim is projected point by point and the
    area's centroid follows by Green's theorem.
    """
    angle = np.linspace(0.0, 2.0 * np.pi, 720, endpoint=False)
    rim = centre_mm + radius_mm * np.stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)], axis=1)
    p = project(camera, rim)
    origin = p.mean(axis=0)
    p = p - origin
    q = np.roll(p, -1, axis=0)
    cross = p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]
    centroid: Array = origin + ((p + q) * cross[:, None]).sum(axis=0) / (3.0 * cross.sum())
    return centroid


def measured_centroid(camera: Camera, channel: Array, centre_mm: Array, reach_mm: float) -> Array:
    """(2,) centroid of the light above the darkest level, over the pixels that show the disc's plane within `reach_mm`
    of its centre."""
    centre_px = project(camera, centre_mm[None])[0]
    mm_per_px = np.linalg.inv(project_jacobian(camera, centre_mm[None])[0][:, :2])
    u0, v0 = np.maximum(np.floor(centre_px - GROUND_PX).astype(int), 0)
    u1, v1 = np.ceil(centre_px + GROUND_PX).astype(int) + 1
    window = channel[v0:v1, u0:u1].astype(float)
    v, u = np.mgrid[v0 : v0 + window.shape[0], u0 : u0 + window.shape[1]]
    away_mm = np.linalg.norm((np.stack([u, v], axis=-1) - centre_px) @ mm_per_px.T, axis=-1)
    weight = np.where(away_mm <= reach_mm, window - window[away_mm <= reach_mm].min(), 0.0)
    centroid: Array = np.array([(weight * u).sum(), (weight * v).sum()]) / weight.sum()
    return centroid
