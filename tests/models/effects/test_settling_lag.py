"""The picture was taken before the arm arrived: a fraction of each step is still to go."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from armtwin.models.catalogue.registry import Site, effect_named
from tests.support.contexts import context_of, one_joint, turned

PATHS = st.lists(st.floats(-1.0, 1.0), min_size=2, max_size=20)


def reached(path: object, remaining: float) -> np.ndarray:
    return turned("settling_lag", context_of(one_joint(1, path), timed=False), [remaining, 0.0, 0.0, 0.0])[:, 0]


@given(PATHS, st.floats(0.0, 0.9))
def test_the_arm_stands_between_where_it_was_and_where_it_goes(path: list[float], remaining: float) -> None:
    at = reached(path, remaining)
    low, high = np.minimum(at[:-1], path[1:]), np.maximum(at[:-1], path[1:])
    assert ((at[1:] >= low - 1e-12) & (at[1:] <= high + 1e-12)).all()


def test_at_its_first_pose_it_has_arrived() -> None:
    assert reached([0.4, 0.4], 0.5)[0] == 0.4


def test_what_remains_of_a_step_shrinks_by_the_fraction_with_each_pose() -> None:
    np.testing.assert_allclose(1.0 - reached([0.0, 1.0, 1.0, 1.0], 0.3), [1.0, 0.3, 0.09, 0.027])


@pytest.mark.parametrize(("waits_matter", "left"), [(1.0, 0.3**2), (0.0, 0.3)])
def test_after_twice_the_usual_wait_the_fraction_is_squared_if_waits_matter(waits_matter: float, left: float) -> None:
    times = np.array([0.0, 1.0, 2.0, 3.0, 5.0])
    context = context_of(one_joint(1, [0.0, 0.0, 0.0, 0.0, 1.0]), time_s=times)
    assert 1.0 - turned("settling_lag", context, [0.3, 0.0, 0.0, waits_matter])[-1, 0] == pytest.approx(left)


def test_a_twin_holds_no_overshoot_and_says_after_which_wait_its_parts_are_left() -> None:
    values = np.array([0.3, -0.1, 0.0, 1.0])
    built = effect_named("settling_lag").built(context_of(), Site(), values)
    assert built == {"remaining1": 0.3, "remaining2": 0.0, "remaining3": 0.0, "wait_s": 2.0}
    assert "wait_s" not in effect_named("settling_lag").built(context_of(timed=False), Site(), values)
