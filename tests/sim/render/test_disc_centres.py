"""The renderer is the measuring instrument of every other test: discs lie where the camera model projects them."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from armtwin.models.camera import Camera
from armtwin.models.lenses import Equidistant, Lens, Rational, ThinPrism, TiltedThinPrism
from armtwin.sim.render import LensRenderer, panel_parts
from tests.sim.render.cameras import webcam
from tests.sim.render.field import GROUND_PX, RADIUS_PX, disc_field, image_centroid, measured_centroid, pixel_grid

Array = NDArray[np.float64]

# A tenth of these is reached; they are what the measurements built on the renderer need.
MEAN_PX, RMS_PX, WORST_PX = 0.005, 0.02, 0.06


@pytest.mark.parametrize(
    ("supersampling", "tilt_deg", "axis"),
    [
        (2, 0.0, (1.0, 0.0, 0.0)),
        (2, 25.0, (1.0, 0.0, 0.0)),
        (2, 25.0, (0.0, 1.0, 0.0)),
        (2, 25.0, (0.6, 0.8, 0.0)),
        (3, 25.0, (0.6, 0.8, 0.0)),
    ],
)
def test_disc_centres_all_over_the_picture_are_true(
    supersampling: int, tilt_deg: float, axis: tuple[float, float, float]
) -> None:
    camera = webcam(tilt_deg, axis)
    pixels = pixel_grid(camera)
    assert len(pixels) >= 300
    check_discs(camera, pixels, supersampling)


WIDE = [0.28, -0.126, 0.001, -0.0005, -0.01, 0.55, -0.11, -0.036]
PRISM = [0.002, -0.001, -0.003, 0.0005]


@pytest.mark.parametrize(
    ("lens", "focal_px"),
    [
        (Equidistant(np.array([0.0368, 0.0091, -0.0097, 0.001])), 320.0),  # 71 degrees from the axis to the corners
        (Rational(np.array(WIDE)), 400.0),
        (ThinPrism(np.array([*WIDE, *PRISM])), 400.0),
        (TiltedThinPrism(np.array([*WIDE, *PRISM, 0.03, -0.05])), 400.0),
    ],
    ids=lambda value: getattr(value, "model", ""),
)
def test_disc_centres_are_true_through_every_lens(lens: Lens, focal_px: float) -> None:
    K = np.array([[focal_px, 0.0, 318.3], [0.0, focal_px + 1.0, 241.9], [0.0, 0.0, 1.0]])
    camera = Camera(640, 480, K, lens, np.diag([-1.0, -1.0, 1.0]), np.array([0.0, 0.0, 485.0]))
    check_discs(camera, pixel_grid(camera, 12, 9), supersampling=3)


def check_discs(camera: Camera, pixels: Array, supersampling: int) -> None:
    """Render discs whose centres project to `pixels`, and compare their images with their outlines' projection."""
    parts, centres, radii = disc_field(camera, pixels)
    with LensRenderer(camera, [*panel_parts(), *parts], supersampling=supersampling) as renderer:
        red = renderer.render({})[..., 2]
    reach = 0.5 * (1.0 + GROUND_PX / RADIUS_PX)
    error = np.array(
        [
            measured_centroid(camera, red, centre, reach * radius) - image_centroid(camera, centre, radius)
            for centre, radius in zip(centres, radii, strict=True)
        ]
    )
    assert np.all(np.abs(error.mean(axis=0)) < MEAN_PX)
    assert np.all(np.sqrt((error**2).mean(axis=0)) < RMS_PX)
    assert np.abs(error).max() < WORST_PX


def test_the_field_of_discs_reaches_all_four_corners() -> None:
    camera = webcam()
    pixels = pixel_grid(camera)
    for corner in [(0, 0), (1279, 0), (0, 719), (1279, 719)]:
        assert np.linalg.norm(pixels - corner, axis=1).min() < 2.0 * RADIUS_PX
