"""The closed bound is the Fisher information of a drawn disc."""

from __future__ import annotations

import numpy as np
import pytest

from armtwin.calib.markers import centre_bound
from armtwin.models.camera import Camera
from armtwin.models.lenses import PlumbBob
from tests.support.discs import FACE, GROUND, draw_discs

K = np.array([[1000.0, 0.0, 120.0], [0.0, 1000.0, 120.0], [0.0, 0.0, 1.0]])
SQUARE_ON = Camera(241, 241, K, PlumbBob(np.zeros(5)), np.eye(3), np.array([0.0, 0.0, 1000.0]))  # 1 mm is 1 px


@pytest.mark.parametrize(("radius", "blur"), [(20.0, 1.0), (20.0, 3.0), (6.0, 0.7)])
def test_bound_is_the_inverse_fisher_information_of_the_picture(radius: float, blur: float) -> None:
    step, noise = 0.05, 2.0
    right, left = (draw_discs(SQUARE_ON, np.array([[x, 0.2]]), radius, 0.0, blur) for x in (step, -step))
    information = np.sum(((right - left) / (2.0 * step)) ** 2) / (noise**2 + 1.0 / 12.0)
    curvature = (blur / radius) ** 2  # what the bound leaves out of a curved edge; 1 % more for the drawing's steps
    assert centre_bound(radius, FACE - GROUND, blur, noise) == pytest.approx(information**-0.5, rel=curvature + 0.01)


def test_a_disc_of_twice_the_contrast_can_be_known_twice_as_well() -> None:
    assert centre_bound(20.0, 100.0, 1.0, 2.0) == pytest.approx(2.0 * centre_bound(20.0, 200.0, 1.0, 2.0))
