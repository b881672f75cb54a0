"""A horn that slips: a zero that jumps at one sample."""

import numpy as np
import pytest

from armtwin.models.catalogue.jumps import jumps
from armtwin.models.catalogue.registry import Site, effect_named
from tests.support.contexts import context_of, turned


def test_the_zero_jumps_at_its_sample_and_stays_there() -> None:
    context = context_of()
    error = turned("joint_slip", context, [0.03, 12.0, 0.0, 40.0, 0.0, 40.0, 0.0, 40.0], joint=2) - context.q_cmd
    np.testing.assert_allclose(error[:, 1], np.where(np.arange(40) < 12, 0.0, 0.03), atol=1e-15)
    assert not error[:, [0, 2]].any()


def test_slips_add_up_and_one_that_never_comes_does_nothing() -> None:
    context = context_of()
    error = turned("joint_slip", context, [0.03, 12.0, -0.05, 20.0, 0.2, 40.0, 0.2, 40.0], joint=1) - context.q_cmd
    np.testing.assert_allclose(error[[11, 12, 20, 39], 0], [0.0, 0.03, -0.02, -0.02], atol=1e-15)


def test_a_twin_has_the_slips_that_came_and_no_others() -> None:
    values = np.array([0.03, 12.0, -0.05, 20.0, 0.0, 40.0, 0.0, 40.0])
    built = effect_named("joint_slip").built(context_of(), Site(joint=1), values)
    assert built == {"jump_rad": 0.03, "from_sample": 12, "jump2_rad": -0.05, "from_sample2": 20}


@pytest.mark.parametrize("slips", [{37: 0.02}, {20: 0.03, 300: -0.03}, {50: 0.01, 90: 0.02, 200: -0.04, 380: 0.03}])
def test_what_a_joint_departs_by_tells_when_it_slipped(slips: dict[int, float]) -> None:
    departures = np.random.default_rng(0).normal(0.0, 0.002, 400)
    for row, jump in slips.items():
        departures[row:] += jump
    found = dict(jumps(departures, np.ones(400), most=4))
    assert list(found) == list(slips)
    np.testing.assert_allclose(list(found.values()), list(slips.values()), atol=0.004)


def test_noise_jumps_nowhere() -> None:
    assert not jumps(np.random.default_rng(1).normal(0.0, 1.0, 300), np.ones(300), most=4)
