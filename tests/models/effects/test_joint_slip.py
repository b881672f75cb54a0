"""A horn that slips: a zero that jumps at one sample."""

import numpy as np

from armtwin.models.catalogue.registry import Site, effect_named
from tests.support.contexts import context_of, turned


def test_the_zero_jumps_at_its_sample_and_stays_there() -> None:
    context = context_of()
    error = turned("joint_slip", context, [0.03, 12.0], joint=2) - context.q_cmd
    np.testing.assert_allclose(error[:, 1], np.where(np.arange(40) < 12, 0.0, 0.03), atol=1e-15)
    assert not error[:, [0, 2]].any()


def test_a_coarse_scan_is_refined_to_single_samples() -> None:
    context = context_of(np.zeros((400, 3)))
    starts = effect_named("joint_slip").starts
    coarse = [start[1] for start in starts(context, Site(joint=1), None)]
    for slipped in range(1, 400):
        nearest = min(coarse, key=lambda row: abs(row - slipped))
        fine = [start[1] for start in starts(context, Site(joint=1), np.array([0.0, nearest]))]
        assert slipped in fine
