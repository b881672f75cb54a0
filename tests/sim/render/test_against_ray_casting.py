"""Every pixel shows the light of its own area: compared with rays cast backwards through the lens, 36 a pixel.

The renderer maps points forwards, vertex by vertex, and averages samples of triangles; the reference maps pixels
backwards by the inverse of the distortion and looks up the pattern, so that a swapped map, a shifted half pixel, a
flipped axis or a missing border shows in it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from armtwin.models.camera import Camera, back_project
from armtwin.models.lenses import PlumbBob
from armtwin.sim.render import LensRenderer, Light, chessboard_parts, disc
from armtwin.sim.render.stickers import BLACK, RED, WHITE
from tests.sim.render.cameras import D, webcam

Array = NDArray[np.float64]

SQUARE_MM = 23.0
_RAYS = 6  # along each side of a pixel


def small_webcam(distortion: Array, tilt_deg: float = 20.0) -> Camera:
    """The webcam at a lower resolution: the same lens, fewer rays to cast."""
    camera = webcam(tilt_deg)
    share = 240 / 1280
    K = np.diag([share, share, 1.0]) @ camera.K
    K[:2, 2] += 0.5 * share - 0.5  # between centres of pixels: (c + 1/2) share - 1/2
    return replace(camera, image_width=240, image_height=135, K=K, lens=PlumbBob(distortion))


def rays_on_plane(camera: Camera, T_body_board: Array) -> Array:
    """(R, H, W, 2) points of a flat body's plane, mm, that the rays of each pixel meet."""
    T = camera.T_board_camera @ T_body_board
    seen = replace(camera, R_board_camera=T[:3, :3], t_board_camera_mm=T[:3, 3])
    offsets = (np.arange(_RAYS) + 0.5) / _RAYS - 0.5
    v, u = np.mgrid[0 : camera.image_height, 0 : camera.image_width].astype(float)
    pixels = np.stack([np.stack([u + du, v + dv], axis=-1) for du in offsets for dv in offsets])
    return back_project(seen, pixels.reshape(-1, 2), 0.0)[:, :2].reshape(pixels.shape)


def seen_light(reflectance: Array, T_body_board: Array) -> Array:
    """(H, W) light, 0 to 255, of a flat body that faces the camera, from its reflectance where the rays meet it."""
    light = Light()
    facing = abs(float(T_body_board[:3, 2] @ light.direction))
    return 255.0 * (light.ambient + light.diffuse * facing) * reflectance.mean(axis=0)


def board_pose() -> Array:
    """The chessboard's first corner towards the picture's upper left, filling the picture and more."""
    T = np.diag([-1.0, -1.0, 1.0, 1.0])
    T[:3, 3] = 105.0, 60.0, -60.0
    return T


LENSES = {
    "webcam": D,
    "barrel": np.array([-0.45, 0.12, 0.0, 0.0, 0.0]),
    "off-centre pincushion": np.array([0.5, 0.3, 0.04, -0.03, 0.0]),
}


@pytest.mark.parametrize("lens", LENSES)
def test_every_pixel_of_a_chessboard_shows_its_own_area(lens: str) -> None:
    camera, T = small_webcam(LENSES[lens]), board_pose()
    with LensRenderer(camera, chessboard_parts(margin_mm=200.0)) as renderer:
        red = renderer.render({"board": T})[..., 2].astype(float)
    met = rays_on_plane(camera, T) / SQUARE_MM
    i, j = np.floor(met[..., 0] + 1.0), np.floor(met[..., 1] + 1.0)
    printed = (i >= 0) & (i < 10) & (j >= 0) & (j < 7)
    difference = red - seen_light(np.where(printed & ((i + j) % 2 == 0), BLACK[0], WHITE[0]), T)
    assert abs(difference.mean()) < 0.5
    assert np.sqrt((difference**2).mean()) < 3.0
    # The outline of the squares is an edge of the mesh, known to one of the samples, a quarter of a pixel ...
    assert np.abs(difference).max() < 0.25 * 255.0
    # ... and the edges between squares are printed, and better known.
    between = printed.all(axis=0)
    assert between.mean() > 0.2
    assert np.abs(difference[between]).max() < 0.1 * 255.0


def test_every_pixel_of_a_disc_shows_its_own_area() -> None:
    camera = small_webcam(D, tilt_deg=25.0)
    T = np.diag([1.0, -1.0, -1.0, 1.0])
    T[:3, 3] = 12.3, -4.5, 6.7
    with LensRenderer(camera, [disc("disc", 40.0, 400.0).on("disc")]) as renderer:
        red = renderer.render({"disc": T})[..., 2].astype(float)
    distance = np.linalg.norm(rays_on_plane(camera, T), axis=-1)
    difference = red - seen_light(np.where(distance < 40.0, RED[0], BLACK[0]), T)
    assert abs(difference.mean()) < 0.5
    assert np.abs(difference).max() < 0.1 * 255.0
