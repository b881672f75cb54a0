"""A plane nearer or farther than assumed: no data of one plane can tell it from the geometry."""

import numpy as np

from armtwin.models.catalogue.points import Geometry
from armtwin.models.catalogue.registry import Site, effect_named
from tests.support.contexts import BASE_MM, active, context_of, drawn, pixels, predicted_pixels


def test_it_looks_exactly_like_all_links_and_the_base_s_place_scaled_together() -> None:
    context = context_of()
    camera = context.camera
    assert camera is not None
    offset = 9.0
    centre = -camera.R_board_camera.T @ camera.t_board_camera_mm  # the camera in the board frame
    scale = (BASE_MM[2] - centre[2]) / (BASE_MM[2] + offset - centre[2])
    # Rays through the farther plane meet the assumed one nearer to the foot of the camera.
    base = centre[:2] + scale * (BASE_MM[:2] - centre[:2])
    geometry = drawn(context)
    scaled = Geometry(geometry.base_mm, scale * geometry.links, scale * geometry.corner)
    seen = predicted_pixels(context, scaled, (), np.array([*base, BASE_MM[2]]))
    np.testing.assert_allclose(pixels(context, active("plane_offset", [offset])), seen, atol=1e-6)


def test_so_it_is_never_looked_for() -> None:
    assert effect_named("plane_offset").why_not(context_of(), Site()) is not None
