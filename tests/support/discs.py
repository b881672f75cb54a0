"""Pictures of discs drawn without the renderer: exact areas, blur, noise; independent of what is measured in them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from armtwin.models.camera import Camera, back_project, project, project_jacobian

Array = NDArray[np.float64]
Image = NDArray[np.uint8]

PLANE_MM = -80.87
FACE, GROUND = 200.0, 25.0
# Points of a pixel's side at which the disc is drawn: with soft steps between them areas are good to 1e-4.
_FINE = 4


def draw_discs(
    camera: Camera,
    centres_mm: Array,
    radius_mm: float,
    plane_z_mm: float = PLANE_MM,
    blur_px: float = 1.0,
    face: float = FACE,
    ground: float = GROUND,
) -> Array:
    """(H, W) mean grey levels of discs at (N, 2) board places: each point of a pixel is carried back to the plane."""
    picture = np.full((camera.image_height, camera.image_width), ground)
    for centre in centres_mm:
        place = np.array([[*centre, plane_z_mm]])
        J = project_jacobian(camera, place)[0, :, :2]
        margin = int(np.ceil(radius_mm * np.linalg.norm(J, 2) + 5.0 * blur_px + 3.0))
        left, top = np.rint(project(camera, place)[0]).astype(int) - margin
        side = 2 * margin + 1
        fine = (np.arange(side * _FINE) + 0.5) / _FINE - 0.5
        u, v = np.meshgrid(left + fine, top + fine)
        away = back_project(camera, np.stack([u.ravel(), v.ravel()], axis=1), plane_z_mm)[:, :2] - centre
        distance = np.maximum(np.hypot(*away.T), 1e-9)
        mm_per_px = np.linalg.norm((away / distance[:, None]) @ np.linalg.inv(J), axis=1)
        # Half a fine point's width on both sides of the edge the share goes from 1 to 0.
        share = np.clip(0.5 - (distance - radius_mm) / mm_per_px * _FINE, 0.0, 1.0).reshape(side * _FINE, -1)
        if blur_px > 0.0:
            share = gaussian_filter(share, blur_px * _FINE, truncate=5.0)
        share = share.reshape(side, _FINE, side, _FINE).mean(axis=(1, 3))
        rows = slice(max(top, 0), min(top + side, camera.image_height))
        columns = slice(max(left, 0), min(left + side, camera.image_width))
        inside = share[rows.start - top : rows.stop - top, columns.start - left : columns.stop - left]
        picture[rows, columns] += (face - ground) * inside
    return picture


def take(picture: Array, noise: float = 0.0, rng: np.random.Generator | None = None, vignetting: float = 0.0) -> Image:
    """(H, W, 3) BGR picture of the mean levels, seen in red; green and blue stay near the ground's level."""
    height, width = picture.shape
    v, u = np.mgrid[:height, :width] - 0.5 * (np.array([height, width]) - 1.0)[:, None, None]
    picture = picture * (1.0 - vignetting * (u**2 + v**2) / (0.25 * (height**2 + width**2)))
    levels = np.stack([0.1 * picture + 15.0, 0.1 * picture + 15.0, picture], axis=-1)
    if rng is not None:
        levels = levels + noise * rng.standard_normal(levels.shape, dtype=np.float32)
    return np.clip(np.rint(levels), 0, 255).astype(np.uint8)


def places_of(camera: Camera, pixels: Array, plane_z_mm: float = PLANE_MM) -> Array:
    """(N, 2) board places that are seen at (N, 2) pixels."""
    return back_project(camera, np.asarray(pixels, float), plane_z_mm)[:, :2]


def true_pixels(camera: Camera, places_mm: Array, plane_z_mm: float = PLANE_MM) -> Array:
    """(N, 2) pixels of board places (N, 2), the truth of every test here."""
    return project(camera, np.column_stack([places_mm, np.full(len(places_mm), plane_z_mm)]))
