"""How far a lens is trusted when it is drawn through."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from armtwin.models.errors import InputError
from armtwin.models.lenses import PlumbBob
from armtwin.sim.render.lens import uniforms_of
from tests.sim.render.cameras import D, webcam


def test_the_polynomial_holds_in_the_whole_picture() -> None:
    assert 0.53 < uniforms_of(webcam()).linear_from < np.tan(PlumbBob(D).limit_rad)


def test_a_lens_that_never_folds_is_followed_wherever_a_ray_goes() -> None:
    never = PlumbBob(np.array([0.2, 0.1, 0.0, 0.0, 0.3]))
    assert uniforms_of(replace(webcam(), lens=never)).linear_from > 1e3


def test_a_lens_that_folds_inside_its_picture_is_refused() -> None:
    with pytest.raises(InputError, match="folds back"):
        uniforms_of(replace(webcam(), lens=PlumbBob(np.array([-2.0, 0.0, 0.0, 0.0, 0.0]))))
