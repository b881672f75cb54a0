"""Quantisation: commands land on whole multiples of a step."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from armtwin.models.catalogue.registry import Site, effect_named
from tests.support.contexts import context_of, one_joint, turned

PATHS = st.lists(st.floats(-1.5, 1.5), min_size=1, max_size=30)
STEPS = st.floats(1e-4, 0.3)


def rounded(path: object, step: float) -> np.ndarray:
    return turned("quantization", context_of(one_joint(1, path)), [step])[:, 0]


@given(PATHS, STEPS)
def test_every_output_is_a_whole_number_of_steps(path: list[float], step: float) -> None:
    counts = rounded(path, step) / step
    np.testing.assert_allclose(counts, np.round(counts), atol=1e-6)


@given(PATHS, STEPS)
def test_no_output_is_more_than_half_a_step_away(path: list[float], step: float) -> None:
    assert (np.abs(rounded(path, step) - path) <= step / 2 + 1e-12).all()


@given(PATHS, STEPS)
def test_what_lies_on_the_grid_stays_there(path: list[float], step: float) -> None:
    once = rounded(path, step)
    np.testing.assert_allclose(rounded(once, step), once, atol=1e-12)


def test_steps_that_are_met_in_practice_are_tried() -> None:
    context = context_of()
    tried = np.array([start[0] for start in effect_named("quantization").starts(context, Site(), None)])
    for step in (np.radians(1.0), np.pi / 256, 2 * np.pi / 1024):
        assert np.abs(tried / step - 1.0).min() < 0.01
