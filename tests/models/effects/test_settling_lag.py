"""The picture was taken before the arm arrived: a fraction of each step is still to go."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from armtwin.models.catalogue.registry import Site, effect_named
from tests.support.contexts import context_of, one_joint, turned

# A reach that no move exceeds.
FREE = 6.6
PATHS = st.lists(st.floats(-1.0, 1.0), min_size=2, max_size=20)


def reached(path: object, remaining: float) -> np.ndarray:
    return turned("settling_lag", context_of(one_joint(1, path), timed=False), [remaining, 0.0, 0.0, FREE, 0.0, 0.0])[
        :, 0
    ]


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
    assert 1.0 - turned("settling_lag", context, [0.3, 0.0, 0.0, FREE, 0.0, waits_matter])[-1, 0] == pytest.approx(left)


def test_a_twin_holds_no_overshoot_and_says_after_which_wait_its_parts_are_left() -> None:
    values = np.array([0.3, -0.1, 0.0, FREE, 0.0, 1.0])
    built = effect_named("settling_lag").built(context_of(), Site(), values)
    assert built == {"remaining1": 0.3, "remaining2": 0.0, "remaining3": 0.0, "wait_s": 2.0}
    assert "wait_s" not in effect_named("settling_lag").built(context_of(timed=False), Site(), values)


def at_speed(path: object, reach: float, remaining: float = 1e-6, pause: float = 0.0) -> np.ndarray:
    values = [remaining, 0.0, 0.0, reach, pause, 0.0]
    return turned("settling_lag", context_of(one_joint(1, path), timed=False), values)[:, 0]


def test_a_slow_servo_covers_its_reach_and_no_more_and_goes_on_from_there() -> None:
    np.testing.assert_allclose(at_speed([0.0, 0.05, 0.35, 0.35, 0.35], 0.1), [0.0, 0.05, 0.15, 0.25, 0.35], atol=5e-3)


def test_close_to_its_goal_a_servo_that_saturates_leaves_a_share() -> None:
    tail = at_speed([0.0, 0.01], 10.0 * 0.1, remaining=0.2)
    np.testing.assert_allclose(tail, at_speed([0.0, 0.01], FREE, remaining=0.2))


def test_with_a_long_pause_after_the_picture_it_arrives_before_the_next_command() -> None:
    np.testing.assert_allclose(at_speed([0.0, 0.3, 0.3, 0.5], 0.1, pause=20.0), [0.0, 0.1, 0.3, 0.4], atol=5e-3)


def test_a_twin_of_a_slow_servo_is_told_its_reach() -> None:
    built = effect_named("settling_lag").built(context_of(), Site(), np.array([0.1, 0.1, 0.1, 0.25, 0.0, 1.0]))
    assert built["reach_rad"] == 0.25


def test_a_speed_alone_leaves_what_is_beyond_its_reach_and_nothing_else() -> None:
    context = context_of(one_joint(1, [0.0, 0.1, 0.6, 0.7]))
    n = context.q_cmd.shape[1]
    out = turned("settling_lag", context, [*np.zeros(n), 0.2, 0.5, 0.0])[:, 0]
    # 0.3 of the way are left at the third pose, and 0.2 when the next command comes, half a wait later.
    np.testing.assert_allclose(out, [0.0, 0.1, 0.3, 0.6])
