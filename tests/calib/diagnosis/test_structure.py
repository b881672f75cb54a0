"""What a remainder follows."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from armtwin.calib.diagnosis.fit import Data, Fit, fit
from armtwin.calib.diagnosis.problem import problem_of
from armtwin.calib.diagnosis.structure import trends
from tests.support.recordings import recording


def remainder(change: np.ndarray | None = None) -> tuple[Data, Fit]:
    problem = problem_of(recording())
    data = Data(problem, np.isfinite(problem.observed).all(axis=-1), 0.05)
    model = fit(data, problem.nominal, ())
    return data, model if change is None else replace(model, residual=model.residual + change)


def names(data: Data, model: Fit) -> list[str]:
    return [trend.against for trend in trends(data, model)]


def test_noise_follows_nothing() -> None:
    assert names(*remainder()) == []


def test_a_creep_follows_order_and_time() -> None:
    creep = np.linspace(-0.2, 0.2, 120)[:, None, None] * np.array([1.0, 0.0])
    assert {"order", "time"} <= set(names(*remainder(creep + np.zeros((120, 4, 2)))))


def test_an_error_over_an_angle_follows_that_angle_most() -> None:
    data, model = remainder()
    q = data.problem.context.q_cmd[:, 1]
    wave = 0.3 * np.sin(3.0 * q)[:, None, None] * np.array([0.0, 1.0])
    changed = replace(model, residual=model.residual + wave)
    assert "angle of joint 2" in names(data, changed)[:2]


def test_an_error_by_side_follows_the_direction_of_approach() -> None:
    data, model = remainder()
    q = data.problem.context.q_cmd[:, 0]
    side = 0.2 * np.sign(np.diff(q, prepend=q[0]))[:, None, None]
    assert "direction of approach" in names(data, replace(model, residual=model.residual + side))


def test_what_moves_all_markers_of_a_pose_alike_shows_without_any_order() -> None:
    jump = np.random.default_rng(3).normal(0.0, 0.1, (120, 1, 2))
    assert "the same pose's other markers" in names(*remainder(jump + np.zeros((120, 4, 2))))
