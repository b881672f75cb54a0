"""A recording as a regression."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from armtwin.calib.diagnosis.problem import problem_of
from armtwin.models.catalogue.predict import Active, joint_angles
from armtwin.models.catalogue.registry import Site, effect_named
from tests.support.recordings import BASE_MM, recording


@pytest.mark.parametrize("markers", ["abcf", "af", "f"])
def test_the_derivative_by_the_geometry_is_that_of_the_prediction(markers: str) -> None:
    problem = problem_of(recording(markers=markers))
    g = problem.nominal + 0.3
    tilted = (Active(effect_named("camera_tilt"), Site(), np.array([0.05, -0.03])),)
    _, J = problem.predict_with_jacobian(g, tilted)
    for k in range(len(g)):
        step = np.zeros(len(g))
        step[k] = 1e-4
        slope = (problem.predict(g + step, tilted) - problem.predict(g - step, tilted)) / 2e-4
        np.testing.assert_allclose(J[..., k], slope, atol=1e-5)


def test_the_derivative_by_the_joints_is_that_of_the_prediction() -> None:
    problem = problem_of(recording())
    g = problem.nominal + 0.3
    gain = effect_named("servo_gain")
    for joint in (1, 2, 3):
        small = (Active(gain, Site(joint=joint), np.array([1.0 + 1e-6])),)
        q = joint_angles(problem.context, ())
        J = problem.jacobian_by_joint(g, q)
        slope = (problem.predict(g, small) - problem.predict(g, ())) / 1e-6
        np.testing.assert_allclose(np.einsum("nmdj,nj->nmd", J[..., [joint - 1]], q[:, [joint - 1]]), slope, atol=2e-2)


def test_the_base_is_found_from_the_pictures_of_marker_a() -> None:
    problem = problem_of(recording())
    np.testing.assert_allclose(problem.base_in_board_mm, BASE_MM, atol=0.05)


def test_measured_angles_are_a_regression_too() -> None:
    made = recording()
    angles = replace(made, markers_px={}, camera=None, q_meas=made.q_cmd + 0.1)
    problem = problem_of(angles)
    assert not problem.is_pixels
    np.testing.assert_allclose(problem.predict(np.full(3, 0.1), ())[..., 0], angles.q_meas)
