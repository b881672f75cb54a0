"""Errors on the validation trajectory, compared."""

import numpy as np
import pytest

from armtwin.scenarios.runner.gain import noise_floor_mm, reduction


def test_the_noise_floor_is_the_mean_miss_that_noise_alone_makes_of_a_tip_measured_from_the_base() -> None:
    rng = np.random.default_rng(0)
    marker_rms_mm = 0.2
    tip, base = rng.normal(0.0, marker_rms_mm / np.sqrt(2.0), (2, 200_000, 2))
    assert noise_floor_mm(marker_rms_mm) == pytest.approx(np.linalg.norm(tip - base, axis=1).mean(), rel=0.01)


def test_the_interval_of_a_reduction_holds_it_and_is_wider_where_stretches_differ() -> None:
    rng = np.random.default_rng(1)
    before, even = rng.uniform(3.5, 4.5, 50), rng.uniform(0.3, 0.5, 50)
    uneven = even * np.repeat([0.2, 1.8], 25)
    widths = []
    for error in (even, uneven):
        (low_mm, high_mm), (low, high) = reduction(before, error)
        assert low_mm < error.mean() < high_mm
        assert low < 100.0 * (1.0 - error.mean() / before.mean()) < high
        widths.append(high - low)
    assert widths[1] > 2.0 * widths[0]


def test_poses_that_were_not_seen_are_left_out_of_both() -> None:
    before, error = np.full(20, 4.0), np.full(20, 1.0)
    before[3], error[7] = np.nan, np.nan
    mean, less = reduction(before, error)
    assert np.allclose(mean, 1.0)
    assert np.allclose(less, 75.0)
