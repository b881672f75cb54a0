"""Noise that a recording does not declare."""

from __future__ import annotations

import numpy as np
import pytest

from armtwin.calib.diagnosis.noise import estimate_noise, robust_std
from armtwin.calib.diagnosis.problem import problem_of
from tests.support.recordings import gain_of, recording


def test_the_robust_standard_deviation_is_that_of_gaussian_noise() -> None:
    values = np.random.default_rng(0).normal(0.0, 2.0, 20_000)
    assert robust_std(values) == pytest.approx(2.0, rel=0.02)


@pytest.mark.parametrize("markers", ["abcf", "f"])
def test_a_smooth_cause_does_not_raise_the_noise(markers: str) -> None:
    problem = problem_of(recording(gain_of(1, 1.02), noise_px=0.1, markers=markers))
    residual = problem.observed - problem.predict(problem.nominal, ())
    tolerance = 0.25 if markers == "abcf" else 6.0  # without marker A only an upper bound is left
    assert 0.07 < estimate_noise(problem, residual) < 0.1 * (1 + tolerance)
