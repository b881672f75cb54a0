"""Which models the data cannot tell apart."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from armtwin.calib.diagnosis.candidates import CandidateModel
from armtwin.calib.diagnosis.fit import Data, fit
from armtwin.calib.diagnosis.problem import problem_of
from armtwin.calib.diagnosis.ties import tied
from armtwin.models.catalogue.predict import Active
from armtwin.models.catalogue.registry import Site, effect_named
from tests.support.recordings import recording

GAIN = Active(effect_named("servo_gain"), Site(joint=2), np.array([1.0]))


@pytest.fixture(scope="module")
def best() -> tuple[Data, CandidateModel]:
    problem = problem_of(recording())
    data = Data(problem, np.isfinite(problem.observed).all(axis=-1), 0.05)
    return data, CandidateModel(GAIN, fit(data, problem.nominal, (GAIN,)), 5.0)


def worse(one: CandidateModel, by_pose: np.ndarray) -> CandidateModel:
    """Return a model that misses each pose by so much more, spread over its markers."""
    misfit = one.fit.misfit + by_pose[:, None] / one.fit.misfit.shape[1]
    return replace(one, fit=replace(one.fit, misfit=misfit, deviance=one.fit.deviance + float(by_pose.sum())))


@pytest.mark.parametrize(("difference", "same"), [(6.0, True), (12.0, False)])
def test_models_are_told_apart_by_their_scores(
    best: tuple[Data, CandidateModel], difference: float, same: bool
) -> None:
    data, one = best
    other = worse(one, np.full(len(data.counts), difference / len(data.counts)))
    assert tied(data, one, other, excess=1e4, remaining=0.0) == same


def test_what_the_best_fails_to_explain_widens_a_tie(best: tuple[Data, CandidateModel]) -> None:
    data, one = best
    other = worse(one, np.full(len(data.counts), 100.0 / len(data.counts)))
    assert not tied(data, one, other, excess=1e3, remaining=100.0)
    assert tied(data, one, other, excess=1e3, remaining=400.0)


def test_a_small_difference_that_one_run_of_poses_makes_is_a_tie(best: tuple[Data, CandidateModel]) -> None:
    data, one = best
    n = len(data.counts)
    few = np.zeros(n)
    few[0] = 50.0
    assert tied(data, one, worse(one, few), excess=1e4, remaining=0.0)
    assert not tied(data, one, worse(one, np.full(n, 50.0 / n)), excess=1e4, remaining=0.0)
