"""The same lens is the same, whatever a file calls it."""

from __future__ import annotations

import numpy as np
import pytest

from armtwin.models.errors import InputError
from armtwin.models.lenses import Equidistant, PlumbBob, Rational, ThinPrism, TiltedThinPrism, lens_named

FIVE = [-0.03, 0.035, -0.0001, -0.0001, -0.012]


@pytest.mark.parametrize("model", ["plumb_bob", "rational_polynomial"])
@pytest.mark.parametrize("zeros", [0, 3, 7, 9])
def test_more_coefficients_that_are_zero_make_the_same_plumb_bob(model: str, zeros: int) -> None:
    lens = lens_named(model, [*FIVE, *[0.0] * zeros])
    assert isinstance(lens, PlumbBob)
    np.testing.assert_array_equal(lens.coefficients, FIVE)


def test_four_coefficients_are_a_plumb_bob_without_k3() -> None:
    np.testing.assert_array_equal(lens_named("plumb_bob", FIVE[:4]).coefficients, [*FIVE[:4], 0.0])


@pytest.mark.parametrize(("count", "kind"), [(8, Rational), (12, ThinPrism), (14, TiltedThinPrism)])
def test_the_number_of_coefficients_tells_opencvs_models_apart(count: int, kind: type) -> None:
    assert type(lens_named("rational_polynomial", np.full(count, 0.01))) is kind


def test_a_fisheye_has_four() -> None:
    assert isinstance(lens_named("equidistant", [0.1, 0.0, 0.0, 0.0]), Equidistant)
    with pytest.raises(InputError, match="found 5 numbers for 'equidistant', wanted 4"):
        lens_named("equidistant", [0.1] * 5)


@pytest.mark.parametrize("model", ["plumb_bob", "", "none"])
def test_no_coefficients_are_no_distortion(model: str) -> None:
    np.testing.assert_array_equal(lens_named(model, []).coefficients, np.zeros(5))


def test_an_unknown_model_is_named_with_what_there_is() -> None:
    with pytest.raises(InputError, match="distortion_model: found 'omni', wanted one of plumb_bob"):
        lens_named("omni", [0.0])


def test_a_number_of_coefficients_that_no_model_has_is_named() -> None:
    with pytest.raises(InputError, match="found 6 numbers for 'plumb_bob', wanted 0, 4, 5, 8, 12 or 14"):
        lens_named("plumb_bob", [0.1] * 6)
