"""Edge points on normals, and the grey levels that they hang on."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from armtwin.calib.markers.edges import find_edges, first_edges, sample
from armtwin.models.camera import Camera
from armtwin.models.lenses import PlumbBob
from tests.support.discs import draw_discs

Array = NDArray[np.float64]

K = np.array([[1000.0, 0.0, 120.0], [0.0, 1000.0, 120.0], [0.0, 0.0, 1.0]])
SQUARE_ON = Camera(241, 241, K, PlumbBob(np.zeros(5)), np.eye(3), np.array([0.0, 0.0, 1000.0]))  # 1 mm is 1 px
MIDDLE = np.array([[120.3, 119.8]])
NORMALS = 80


def picture(blur_px: float) -> NDArray[np.uint8]:
    return np.rint(draw_discs(SQUARE_ON, MIDDLE - 120.0, 20.0, 0.0, blur_px)).astype(np.uint8)


def radii(points: Array) -> Array:
    return np.linalg.norm(points[0] - MIDDLE[0], axis=-1)


def test_sampling_interpolates_between_pixels_and_knows_the_border() -> None:
    image = np.array([[0, 10], [20, 30]], np.uint8)
    assert sample(image, np.array([0.25, 1.0]), np.array([0.5, 1.0])) == pytest.approx([12.5, 30.0], abs=0.05)
    assert np.isnan(sample(image, np.array([-0.1, 0.5]), np.array([0.5, 1.1]))).all()


@pytest.mark.parametrize("blur_px", [0.5, 1.0, 2.0])
def test_first_edges_from_an_ellipse_a_pixel_off_are_near_the_edge(blur_px: float) -> None:
    edges = first_edges(picture(blur_px), MIDDLE + np.array([0.8, -0.6]), 19.5 * np.eye(2)[None], NORMALS)
    assert edges.mask.all()
    assert radii(edges.points) == pytest.approx(np.full(NORMALS, 20.0), abs=max(0.35, 0.4 * blur_px))


@pytest.mark.parametrize("blur_px", [0.7, 1.0, 2.0])
def test_edge_points_lie_on_the_edge(blur_px: float) -> None:
    blur, noise = np.array([1.1 * blur_px]), np.zeros(1)
    for _ in range(3):
        edges = find_edges(picture(blur_px), MIDDLE, 20.0 * np.eye(2)[None], NORMALS, blur, noise)
        blur, noise = edges.blur, edges.noise
    # A blurred convex edge crosses half its height blur^2 / (2 radius) inside; edges of sharp pictures are coarser.
    assert radii(edges.points).mean() == pytest.approx(20.0 - blur_px**2 / 40.0, abs=0.05)
    assert radii(edges.points).std() < 0.03
    # Pixel and interpolation widen the blur.
    assert edges.blur[0] == pytest.approx(np.sqrt(blur_px**2 + 0.25), abs=0.08)


def test_noise_is_told_from_blur(rng: np.random.Generator) -> None:
    noisy = np.clip(np.rint(picture(1.0) + rng.normal(0.0, 4.0, (241, 241))), 0, 255).astype(np.uint8)
    first = find_edges(noisy, MIDDLE, 20.0 * np.eye(2)[None], NORMALS, np.array([1.4]), np.zeros(1))
    edges = find_edges(noisy, MIDDLE, 20.0 * np.eye(2)[None], NORMALS, first.blur, first.noise)
    assert edges.noise[0] == pytest.approx(4.0, rel=0.25)


def test_normals_across_a_cover_are_masked() -> None:
    image = picture(1.0)
    image[:, 130:] = 25
    edges = find_edges(image, MIDDLE, 20.0 * np.eye(2)[None], NORMALS, np.array([1.1]), np.zeros(1))
    angle = 2.0 * np.pi * np.arange(NORMALS) / NORMALS
    assert not edges.mask[0, np.cos(angle) > 0.4].any()
    assert edges.mask[0, np.cos(angle) < 0.0].all()
