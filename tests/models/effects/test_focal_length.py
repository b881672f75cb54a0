"""The focal length is off, or changed on the way."""

from dataclasses import replace

import numpy as np

from tests.support.contexts import active, context_of, pixels


def test_the_picture_is_that_of_a_lens_of_so_much_longer_focal_length() -> None:
    context = context_of()
    assert context.camera is not None
    K = context.camera.K.copy()
    K[:2, :2] *= 1.03
    zoomed = replace(context, camera=replace(context.camera, K=K))
    np.testing.assert_allclose(pixels(context, active("focal_length", [1.03, 0.0])), pixels(zoomed), atol=1e-9)


def test_autofocus_changes_it_from_one_sample_on() -> None:
    context = context_of()
    moved = (pixels(context, active("focal_length", [1.03, 25.0])) - pixels(context)).any(axis=(1, 2))
    np.testing.assert_array_equal(moved, np.arange(40) >= 25)
