"""Grey levels of face and ground, shaded or not, with little even ground or much."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.special import ndtr

from armtwin.calib.markers.levels import Levels, Profile, find_levels

Array = NDArray[np.float64]

T, RADIUS, BLUR = 80, 20.0, 1.0
ANGLE = 2.0 * np.pi * np.arange(T) / T


def profile(outer_px: float) -> Profile:
    n = np.linspace(-6.0, outer_px, 25)[None]
    slope = np.exp(-0.5 * (n / BLUR) ** 2) / (np.sqrt(2.0 * np.pi) * BLUR)
    return Profile(n, ndtr(-n / BLUR), slope, np.array([RADIUS]), np.array([BLUR]))


def levels(face: Array, ground: Array, outer_px: float = 6.0, noise: float = 0.0, seed: int = 0) -> Levels:
    """Levels of normals whose face (T, S) and ground (T, 1) are these."""
    p = profile(outer_px)
    grey = ground + (face - ground) * p.inside
    grey = grey + noise * np.random.default_rng(seed).standard_normal(grey.shape)
    return find_levels(grey[None], p, np.ones((1, T), bool), np.array([noise]))


def shaded(share: float) -> Array:
    """(T, S) a face of 200 whose level changes by `share` of it from the middle to the right edge."""
    return 200.0 * (1.0 + share * np.cos(ANGLE)[:, None] * (1.0 + profile(6.0).n / RADIUS))


@pytest.mark.parametrize("outer_px", [6.0, 1.5])
def test_even_levels_leave_nothing(outer_px: float) -> None:
    found = levels(np.full((T, 1), 200.0), np.full((T, 1), 25.0), outer_px)
    assert found.height[0] == pytest.approx(np.full(T, 175.0), abs=1.0)
    assert np.abs(found.remainder).max() < 1.0


def test_linear_shading_is_followed() -> None:
    found = levels(shaded(0.02), np.full((T, 1), 25.0))
    assert found.height[0] == pytest.approx(175.0 + 4.0 * np.cos(ANGLE), abs=1.0)
    assert np.abs(found.remainder).max() < 1.0


def test_shading_that_noise_alone_would_feign_is_not_believed() -> None:
    amplitude = [np.ptp(levels(np.full((T, 1), 200.0), np.full((T, 1), 25.0), 6.0, 8.0, k).height) for k in range(20)]
    assert np.median(amplitude) < 2.0


def test_ground_that_is_brighter_on_one_side_is_followed() -> None:
    ground = np.where(np.cos(ANGLE) > 0.0, 45.0, 25.0)[:, None]
    found = levels(np.full((T, 1), 200.0), ground)
    far = np.abs(np.cos(ANGLE)) > 0.4
    assert found.height[0, far] == pytest.approx(200.0 - ground[far, 0], abs=2.0)


def test_normals_without_the_disc_s_contrast_are_masked() -> None:
    ground = np.full((T, 1), 25.0)
    ground[10:20] = 150.0
    found = levels(np.full((T, 1), 200.0), ground)
    assert not found.mask[0, 10:20].any()
    assert found.mask[0, 25:].all()
    assert found.contrast[0] == pytest.approx(175.0, abs=1.0)
