"""Two markers taken for each other in some frames."""

import numpy as np
import pytest

from armtwin.models.catalogue.registry import Site, View, effect_named
from tests.support.contexts import context_of, pixels

NOISE_PX = 0.1


def found(swapped: list[int], pair: tuple[int, int] = (1, 3)) -> list[tuple[Site, np.ndarray]]:
    context = context_of()
    observed = pixels(context) + NOISE_PX * np.random.default_rng(2).standard_normal((40, 4, 2))
    first, second = pair
    observed[swapped, first], observed[swapped, second] = observed[swapped, second], observed[swapped, first]
    how = effect_named("marker_swap").found
    assert how is not None
    find = how.find
    return find(context, View(observed, pixels(context), NOISE_PX))


@pytest.mark.parametrize("pair", [(0, 1), (1, 3), (2, 3)])
def test_the_frames_and_both_markers_are_found(pair: tuple[int, int]) -> None:
    ((site, values),) = found([4, 19, 20], pair)
    assert site == Site(marker="abcf"[pair[0]])
    np.testing.assert_array_equal(values, [pair[1], 4, 19, 20])


def test_in_clean_frames_none_is_found() -> None:
    assert found([]) == []


def test_a_marker_that_was_not_seen_is_swapped_with_none() -> None:
    context = context_of()
    observed = pixels(context)
    observed[5, 1] = np.nan
    how = effect_named("marker_swap").found
    assert how is not None
    find = how.find
    assert find(context, View(observed, pixels(context), NOISE_PX)) == []


def test_the_simulated_bench_is_told_the_other_marker_and_the_samples() -> None:
    physical = effect_named("marker_swap").physical
    assert physical is not None
    assert physical(context_of(), np.array([2.0, 4.0, 19.0])) == {"other": "c", "samples": [4, 19]}
