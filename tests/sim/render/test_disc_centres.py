"""The renderer is the measuring instrument of every other test: discs lie where the camera model projects them."""

from __future__ import annotations

import numpy as np
import pytest

from armtwin.sim.render import LensRenderer, panel_parts
from tests.sim.render.cameras import webcam
from tests.sim.render.field import GROUND_PX, RADIUS_PX, disc_field, image_centroid, measured_centroid, pixel_grid

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
