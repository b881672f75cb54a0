"""Friction-held lag: it grows smoothly after a reversal and saturates."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from armtwin.models.catalogue.registry import Site, effect_named
from tests.support.contexts import context_of, one_joint, turned
from tests.support.worlds import flat_world, with_effect

PATHS = st.lists(st.floats(-1.0, 1.0), min_size=2, max_size=30)


def lag_of(angles: object, lag: float, length: float, side: float = 0.0) -> np.ndarray:
    context = context_of(one_joint(1, angles))
    return (context.q_cmd - turned("hysteresis", context, [lag, length, side], joint=1))[:, 0]


@given(PATHS, st.floats(0.0, 0.1), st.floats(1e-3, 0.5), st.floats(-1.0, 1.0))
def test_the_lag_never_exceeds_its_saturated_value(path: list[float], lag: float, length: float, side: float) -> None:
    assert (np.abs(lag_of(path, lag, length, side)) <= lag + 1e-12).all()


@given(PATHS, st.floats(0.0, 0.1), st.floats(1e-3, 0.5))
def test_it_does_not_matter_in_how_many_steps_a_move_is_made(path: list[float], lag: float, length: float) -> None:
    drive = np.array(path)
    finer = np.empty(2 * len(drive) - 1)
    finer[::2], finer[1::2] = drive, (drive[:-1] + drive[1:]) / 2
    np.testing.assert_allclose(lag_of(finer, lag, length)[::2], lag_of(drive, lag, length), atol=1e-9)


def test_after_long_travel_the_link_trails_by_the_lag_in_either_direction() -> None:
    trailing = lag_of([0.0, 1.0, 0.0], 0.01, 0.05)
    np.testing.assert_allclose(trailing[1:], [0.01, -0.01], rtol=1e-6)


def test_after_a_reversal_the_swing_is_turned_over_by_all_but_1_part_in_e_over_its_length() -> None:
    trailing = lag_of([0.0, 1.0, 1.0 - 0.05], 0.01, 0.05)
    assert 0.01 - trailing[2] == pytest.approx(0.02 * (1.0 - np.exp(-1.0)), rel=1e-6)


def test_a_joint_at_rest_keeps_its_lag() -> None:
    trailing = lag_of([0.0, 0.03, 0.03, 0.03], 0.01, 0.05)
    assert trailing[1] == trailing[2] == trailing[3] > 0.0


def test_a_twin_holds_the_shortest_length_that_bristles_can_make() -> None:
    effect = effect_named("hysteresis")
    built = effect.built(context_of(), Site(joint=2), np.array([0.02, 0.001, 1.0]))
    assert built == {"lag_rad": 0.02, "length_rad": pytest.approx(0.05)}
    with_effect(flat_world(), "hysteresis", built, joint=2)
