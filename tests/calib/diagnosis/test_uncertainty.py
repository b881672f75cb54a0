"""Standard deviations of fitted models."""

from __future__ import annotations

import numpy as np
import pytest

from armtwin.calib.diagnosis.fit import Data, fit
from armtwin.calib.diagnosis.problem import problem_of
from armtwin.calib.diagnosis.uncertainty import uncertainty
from armtwin.models.catalogue.predict import Active
from armtwin.models.catalogue.registry import Site, effect_named
from tests.support.recordings import gain_of, recording, waves

WORLDS = 200


def test_intervals_of_95_percent_cover_the_truth_in_92_to_98_percent_of_worlds() -> None:
    covered = 0
    for seed in range(WORLDS):
        problem = problem_of(recording(gain_of(3, 1.06), seed=seed, paths=waves(2, 20)))
        data = Data(problem, np.isfinite(problem.observed).all(axis=-1), 0.05)
        gain = Active(effect_named("servo_gain"), Site(joint=3), np.array([1.0]))
        model = fit(data, problem.nominal, (gain,))
        std = uncertainty(data, model).effects_std[0][0]
        covered += abs(model.effects[0].values[0] - 1.06) < 1.96 * std
    assert 0.92 <= covered / WORLDS <= 0.98


def test_a_remainder_that_hangs_together_widens_the_intervals() -> None:
    def creep(pixels: np.ndarray) -> np.ndarray:
        return pixels + np.sin(np.arange(len(pixels)) / 8.0)[:, None, None] * 0.3

    widths = []
    for shift in (lambda pixels: pixels, creep):
        problem = problem_of(recording(shift_px=shift))
        data = Data(problem, np.isfinite(problem.observed).all(axis=-1), 0.05)
        widths.append(uncertainty(data, fit(data, problem.nominal, ())).geometry_std)
    assert (widths[1] > 2 * widths[0]).all()


@pytest.mark.parametrize("sample", [40, 77])
def test_a_jump_between_well_seen_poses_is_known_to_the_pose(sample: int) -> None:
    def slip(q: np.ndarray) -> np.ndarray:
        out = q.copy()
        out[sample:, 1] += 0.02
        return out

    problem = problem_of(recording(slip))
    data = Data(problem, np.isfinite(problem.observed).all(axis=-1), 0.05)
    jump = Active(effect_named("joint_slip"), Site(joint=2), np.array([0.0, float(sample), *3 * [0.0, 1e3]]))
    model = fit(data, problem.nominal, (jump,))
    assert uncertainty(data, model).effects_std[0][1] < 0.5
