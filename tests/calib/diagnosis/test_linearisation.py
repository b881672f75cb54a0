"""The derivative of a fit, held against differences of its predictions."""

from __future__ import annotations

import numpy as np

from armtwin.calib.diagnosis.fit import Data, evaluate
from armtwin.calib.diagnosis.linearisation import linearise, stepped
from armtwin.calib.diagnosis.problem import problem_of
from armtwin.models.catalogue.predict import Active
from armtwin.models.catalogue.registry import Site, effect_named
from tests.support.recordings import recording

NOISE_PX = 0.05
EFFECTS = (
    Active(effect_named("servo_gain"), Site(joint=2), np.array([1.05])),
    Active(effect_named("marker_offset"), Site(marker="b"), np.array([0.5, -0.2, 0.0])),
)


def test_a_derivative_is_the_difference_of_predictions_and_scanned_parameters_have_none() -> None:
    problem = problem_of(recording())
    counts = np.isfinite(problem.observed).all(axis=-1)
    counts[3:9, 1] = False
    data = Data(problem, counts, NOISE_PX)
    at = linearise(data, evaluate(data, problem.nominal, EFFECTS))
    assert [(one.index, one.parameter.name) for one in at.smooth] == [(0, "gain"), (1, "x_mm"), (1, "y_mm")]
    n_g = len(problem.nominal)
    assert at.J.shape == (2 * int(counts.sum()), n_g + 3)
    assert at.precision.shape == (n_g + 3,)
    for column, one in enumerate(at.smooth, start=n_g):
        ahead, behind = (
            problem.predict(problem.nominal, stepped(EFFECTS, one.index, one.k, step))[counts] for step in (1e-4, -1e-4)
        )
        np.testing.assert_allclose(at.J[:, column], (ahead - behind).ravel() / 2e-4 / NOISE_PX, rtol=1e-2, atol=0.05)
    assert np.array_equal(np.unique(at.rows), np.flatnonzero(counts.any(axis=1)))
