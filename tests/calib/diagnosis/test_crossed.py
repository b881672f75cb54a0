"""The gain where poses are few: each is predicted by a model that was fitted to others."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from armtwin.calib.diagnosis.crossed import crossed_predictions
from armtwin.models.catalogue.registry import Site
from tests.support.diagnoses import data_of, explanation_of, fitted, geometry_of
from tests.support.recordings import gain_of, recording, waves

FEW = waves(2, 9)


def test_a_pose_has_no_part_in_its_own_prediction() -> None:
    seen = recording(paths=FEW, held_out=())
    data = data_of(seen)
    explanation = explanation_of(data, geometry_of(data))
    before, _ = crossed_predictions(data, explanation)

    spoilt = data.problem.observed.copy()
    spoilt[4] += 40.0
    worse = replace(data, problem=replace(data.problem, observed=spoilt))
    again, _ = crossed_predictions(worse, explanation)
    same_fold = np.arange(len(spoilt)) % 4 == 0
    np.testing.assert_allclose(again[same_fold], before[same_fold], atol=1e-6)
    assert np.abs(again[~same_fold] - before[~same_fold]).max() > 1.0


def test_the_right_cause_predicts_the_poses_that_it_was_not_fitted_to() -> None:
    data = data_of(recording(gain_of(2, 1.08), paths=FEW, held_out=()))
    before, after = crossed_predictions(data, explanation_of(data, fitted(data, "servo_gain", Site(joint=2), 1.0)))
    assert np.isfinite(before).all()
    rms = [float(np.sqrt(np.mean((data.problem.observed - p) ** 2))) for p in (before, after)]
    assert rms[1] < 0.15 < rms[0]
