"""Ellipses through points: exact where they are, robust where some lie, and with a covariance that holds."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from armtwin.calib.markers.ellipse import fit_ellipses, semi_axes

Array = NDArray[np.float64]


def ellipse_points(n: int = 80, centre: tuple[float, float] = (300.0, 200.0)) -> Array:
    angle = 2.0 * np.pi * np.arange(n) / n
    c, s = np.cos(0.4), np.sin(0.4)
    return np.stack([20.0 * np.cos(angle), 17.0 * np.sin(angle)], axis=1) @ np.array([[c, s], [-s, c]]) + centre


def all_of(points: Array) -> NDArray[np.bool_]:
    return np.ones(points.shape[:2], bool)


def test_points_on_an_ellipse_give_its_centre_and_axes() -> None:
    points = ellipse_points()[None]
    fit = fit_ellipses(points, all_of(points), shape_prior=1.0, steps=4)
    assert fit.centre[0] == pytest.approx([300.0, 200.0], abs=1e-6)
    assert semi_axes(fit.shape)[0] == pytest.approx([20.0, 17.0], abs=1e-6)


def test_two_ellipses_at_once_are_the_same_as_one_by_one(rng: np.random.Generator) -> None:
    points = np.stack([ellipse_points(), ellipse_points(centre=(40.0, 60.0))]) + rng.normal(0.0, 0.05, (2, 80, 2))
    together = fit_ellipses(points, all_of(points), 1.0, 4)
    for k in range(2):
        alone = fit_ellipses(points[k : k + 1], all_of(points[:1]), 1.0, 4)
        assert together.centre[k] == pytest.approx(alone.centre[0], abs=1e-9)


def test_an_eighth_of_gross_errors_moves_the_centre_by_less_than_the_noise(rng: np.random.Generator) -> None:
    points = ellipse_points()[None] + rng.normal(0.0, 0.02, (1, 80, 2))
    points[0, 10:20] += rng.uniform(0.5, 2.0, (10, 1))
    fit = fit_ellipses(points, all_of(points), 1.0, 8)
    assert fit.centre[0] == pytest.approx([300.0, 200.0], abs=0.015)
    assert fit.weights[0, 10:20].max() < 0.1


def test_masked_points_do_not_count() -> None:
    points = ellipse_points()[None]
    mask = all_of(points)
    mask[0, :10] = False
    points[0, :10] += 5.0
    assert fit_ellipses(points, mask, 1.0, 4).centre[0] == pytest.approx([300.0, 200.0], abs=1e-6)


def test_the_prior_holds_half_a_circle_round(rng: np.random.Generator) -> None:
    angle = np.linspace(0.0, np.pi, 40)
    circle = np.stack([20.0 * np.cos(angle), 20.0 * np.sin(angle)], axis=1)
    noisy = circle + rng.normal(0.0, 0.05, (300, 40, 2))
    spread = [fit_ellipses(noisy, all_of(noisy), prior, 4).centre[:, 1].std() for prior in (1.0, 0.001)]
    assert spread[1] < 0.5 * spread[0]


def test_the_covariance_is_the_scatter_of_the_centres(rng: np.random.Generator) -> None:
    points = ellipse_points() + rng.normal(0.0, 0.1, (2000, 80, 2))
    fit = fit_ellipses(points, all_of(points), 1.0, 4)
    predicted = fit.covariance(np.full(2000, 0.1)).mean(axis=0)
    assert np.cov(fit.centre.T) == pytest.approx(predicted, abs=0.12 * predicted[0, 0])


def test_semi_axes_of_a_turned_shape() -> None:
    turn = np.array([[0.6, -0.8], [0.8, 0.6]])
    assert semi_axes((turn @ np.diag([3.0, 7.0]))[None])[0] == pytest.approx([7.0, 3.0])
