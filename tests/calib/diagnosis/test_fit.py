"""The joint fit of geometry and effects."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from armtwin.calib.diagnosis.fit import Data, degrees_of_freedom, fit
from armtwin.calib.diagnosis.problem import Problem, problem_of
from armtwin.calib.diagnosis.screen import Screen
from armtwin.models.catalogue.predict import Active
from armtwin.models.catalogue.registry import Site, effect_named
from tests.support.recordings import DEVIATION, gain_of, recording

NOISE = 0.05


def data_of(problem: Problem) -> Data:
    return Data(problem, np.isfinite(problem.observed).all(axis=-1), NOISE)


def test_geometry_alone_explains_a_world_without_effects_to_the_noise() -> None:
    data = data_of(problem_of(recording()))
    model = fit(data, data.problem.nominal, ())
    links = data.problem.geometry(model.g).links
    np.testing.assert_allclose(np.abs(links[:2]), np.array([120.0, 121.7]) + DEVIATION.lengths_mm[:2], atol=0.05)
    assert model.misfit.sum() / degrees_of_freedom(data, model) == pytest.approx(1.0, abs=0.15)


def test_an_effect_is_fitted_together_with_the_geometry() -> None:
    data = data_of(problem_of(recording(gain_of(2, 1.03))))
    start = fit(data, data.problem.nominal, ())
    model = fit(data, start.g, (Active(effect_named("servo_gain"), Site(joint=2), np.array([1.0])),))
    assert model.effects[0].values[0] == pytest.approx(1.03, abs=5e-4)


def test_a_parameter_at_its_bound_does_not_stop_the_others() -> None:
    data = data_of(problem_of(recording(gravity=-9.81)))
    sag = Active(effect_named("gravity_sag"), Site(), np.array([0.5, *np.zeros(7)]))
    model = fit(data, data.problem.nominal, (sag,), iterations=40)
    assert model.misfit.sum() / degrees_of_freedom(data, model) < 1.2
    assert (model.effects[0].values >= 0.0).all()


def test_the_shape_of_an_effect_that_is_off_stays_where_it_is() -> None:
    data = data_of(problem_of(recording()))
    start = fit(data, data.problem.nominal, ())
    wave = Active(effect_named("servo_nonlinearity"), Site(joint=3), np.array([0.0, 0.0, 7.0, *np.zeros(4)]))
    model = fit(data, start.g, (wave,), iterations=1)
    assert model.effects[0].values[2] == pytest.approx(7.0, abs=1e-6)


def test_points_that_do_not_count_pull_on_nothing() -> None:
    problem = problem_of(recording())
    spoiled = problem.observed.copy()
    spoiled[5, 3] += 400.0
    data = data_of(problem)
    counts = data.counts.copy()
    counts[5, 3] = False
    clean = fit(replace(data, counts=counts), problem.nominal, ())
    dirty = fit(replace(data, problem=replace(problem, observed=spoiled), counts=counts), problem.nominal, ())
    np.testing.assert_allclose(clean.g, dirty.g)


@pytest.mark.parametrize(("name", "values"), [("servo_gain", [1.0]), ("joint_slip", [0.0, 60.0, *3 * [0.0, 1e3]])])
def test_one_step_promises_what_a_fit_of_a_linear_effect_reaches(name: str, values: list[float]) -> None:
    data = data_of(problem_of(recording(gain_of(2, 1.01))))
    base = fit(data, data.problem.nominal, ())
    candidate = Active(effect_named(name), Site(joint=2), np.array(values))
    reached = fit(data, base.g, (candidate,))
    promised = Screen(data, base).promise(candidate)
    assert promised == pytest.approx(reached.deviance, rel=0.05)
