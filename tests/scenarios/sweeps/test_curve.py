import numpy as np
import pytest

from armtwin.scenarios.sweeps.curve import Curve, wilson


def _trials(rng: np.random.Generator, middle: float, lapse: float, n: int) -> tuple[np.ndarray, np.ndarray]:
    sizes = np.exp(rng.uniform(np.log(0.1), np.log(10.0), n))
    rise = 1.0 / (1.0 + np.exp(-(np.log(sizes) - np.log(middle)) / 0.15))
    return sizes, rng.random(n) < (1.0 - lapse) * rise


def test_the_size_found_nine_times_of_ten_lies_in_its_interval() -> None:
    sizes, found = _trials(np.random.default_rng(0), 1.0, 0.0, 200)
    at = Curve(sizes, found, 0.01, 10.0).size_at(0.9)
    true = np.exp(0.15 * np.log(0.9 / 0.1))
    assert at.low is not None
    assert at.high is not None
    assert at.low < true < at.high
    assert at.high / at.low < 1.8


def test_what_is_missed_however_large_is_a_lapse_and_no_larger_size() -> None:
    sizes, found = _trials(np.random.default_rng(1), 1.0, 0.35, 300)
    curve = Curve(sizes, found, 0.01, 10.0)
    assert curve.size_at(0.9).size is None
    half = curve.size_at(0.5).size
    assert half == pytest.approx(np.exp(0.15 * np.log((0.5 / 0.65) / (1 - 0.5 / 0.65))), rel=0.25)
    assert curve.share(10.0)[0] == pytest.approx(0.65, abs=0.08)


def test_without_trials_the_band_is_wide() -> None:
    _, low, high = Curve(np.array([]), np.array([], dtype=bool), 0.01, 10.0).share(0.3)
    assert high - low > 0.8


def test_an_interval_of_a_share_stays_within_one() -> None:
    assert wilson(0, 0) == (0.0, 1.0)
    low, high = wilson(10, 10)
    assert 0.7 < low < high <= 1.0 + 1e-12
