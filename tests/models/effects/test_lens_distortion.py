"""The distortion coefficients do not fit the lens."""

from dataclasses import replace

import numpy as np

from armtwin.models.camera import rays_of
from tests.support.contexts import active, context_of, pixels

CHANGE = [0.05, -0.1, 0.002, -0.001, 0.3]


def test_the_picture_is_that_of_a_lens_with_the_changed_coefficients() -> None:
    context = context_of()
    assert context.camera is not None
    other = replace(context, camera=replace(context.camera, lens=context.camera.lens.changed(CHANGE)))
    np.testing.assert_allclose(pixels(context, active("lens_distortion", CHANGE)), pixels(other), atol=1e-9)


def test_a_radial_change_moves_points_by_the_cube_of_their_distance_from_the_axis() -> None:
    context = context_of()
    assert context.camera is not None
    moved = np.linalg.norm(pixels(context, active("lens_distortion", [0.05, 0, 0, 0, 0])) - pixels(context), axis=-1)
    radius = np.linalg.norm(rays_of(context.camera, pixels(context).reshape(-1, 2))[:, :2], axis=-1)
    np.testing.assert_allclose(moved.ravel(), 0.05 * radius**3 * context.camera.K[0, 0], rtol=1e-3)
