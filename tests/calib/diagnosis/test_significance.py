"""What a remainder is worth: the steps of a reading, and a noise that was estimated from few values."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from armtwin.calib.diagnosis.fit import Data, fit
from armtwin.calib.diagnosis.problem import problem_of
from armtwin.calib.diagnosis.significance import LOUD, at_the_grain, loud_from, of_the_grain
from tests.support.recordings import recording

NOISE_PX = 0.05


def data_of(grain_std: float = 0.0, declared: bool = True) -> Data:
    problem = replace(problem_of(recording()), grain_std=grain_std)
    return Data(problem, np.isfinite(problem.observed).all(axis=-1), NOISE_PX, declared=declared)


def test_noise_is_the_grain_s_only_where_it_is_as_small_as_the_steps() -> None:
    assert at_the_grain(data_of(grain_std=NOISE_PX))
    assert not at_the_grain(data_of(grain_std=NOISE_PX / 10))


def test_a_remainder_beyond_half_a_step_is_not_the_grain_s() -> None:
    data = data_of(grain_std=NOISE_PX)
    model = fit(data, data.problem.nominal, ())
    assert of_the_grain(data, model)
    far = replace(model, misfit=100.0 * model.misfit, residual=10.0 * model.residual)
    assert not of_the_grain(data, far)


def test_an_estimated_noise_asks_for_more_than_a_declared_one_where_values_are_few() -> None:
    data = data_of(declared=False)
    few = replace(data, counts=data.counts & (np.arange(len(data.counts)) < 10)[:, None])
    model = fit(few, few.problem.nominal, ())
    assert loud_from(replace(few, declared=True), model) == LOUD
    assert loud_from(few, model) > LOUD
