"""How far a lens polynomial is trusted."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from armtwin.models.errors import InputError
from armtwin.sim.render.lens import fold_radius, lens_of
from tests.sim.render.cameras import D, webcam


def test_table_2_folds_beyond_the_picture() -> None:
    fold = fold_radius(D)
    assert fold == pytest.approx(0.658, abs=0.002)
    r = np.linspace(0.0, fold, 1000)
    radial = r * (1.0 + D[0] * r**2 + D[1] * r**4 + D[4] * r**6)
    assert np.all(np.diff(radial) > 0.0)
    assert radial.argmax() == 999


@pytest.mark.parametrize("coefficients", [np.zeros(5), np.array([0.2, 0.1, 0.0, 0.0, 0.3])])
def test_a_lens_that_never_folds_has_no_limit(coefficients: np.ndarray) -> None:
    assert fold_radius(coefficients) == np.inf
    assert lens_of(replace(webcam(), D=coefficients)).linear_from > 1e3


def test_the_polynomial_holds_in_the_whole_picture() -> None:
    lens = lens_of(webcam())
    assert 0.53 < lens.linear_from < fold_radius(D)


def test_a_lens_that_folds_inside_its_picture_is_refused() -> None:
    with pytest.raises(InputError, match="folds back"):
        lens_of(replace(webcam(), D=np.array([-2.0, 0.0, 0.0, 0.0, 0.0])))
