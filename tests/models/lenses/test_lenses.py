"""Every lens: what it maps is what OpenCV maps, its inverse and its slopes are its own, and it knows where it folds."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from armtwin.models.lenses import Equidistant, Lens, PlumbBob, Rational, ThinPrism, TiltedThinPrism

Array = NDArray[np.float64]

# Table 2; OpenCV's own sample of a wide webcam; the same behind a prism and a tilted sensor; a 190 degree fisheye.
TABLE_2 = np.array([0.1630, 0.0428, 0.0064, 0.0016, -2.1819])
WIDE = np.array([0.28, -0.126, 0.001, -0.0005, -0.01, 0.55, -0.11, -0.036])
LENSES: list[tuple[Lens, float]] = [
    (PlumbBob(TABLE_2), 30.0),
    (Rational(WIDE), 55.0),
    (ThinPrism(np.array([*WIDE, 0.002, -0.001, -0.003, 0.0005])), 50.0),
    (TiltedThinPrism(np.array([*WIDE, 0.002, -0.001, -0.003, 0.0005, 0.03, -0.05])), 50.0),
    (Equidistant(np.array([0.03678, 0.009125, -0.009733, 0.0010])), 100.0),
]
each_lens = pytest.mark.parametrize(("lens", "reach_deg"), LENSES, ids=lambda case: getattr(case, "model", ""))


def rays_within(reach_deg: float, n: int = 400) -> Array:
    rng = np.random.default_rng(0)
    theta, phi = np.radians(rng.uniform(0.0, reach_deg, n)), rng.uniform(0.0, 2.0 * np.pi, n)
    directions = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1)
    return directions * rng.uniform(50.0, 900.0, (n, 1))


@each_lens
def test_a_ray_lands_where_opencv_projects_it(lens: Lens, reach_deg: float) -> None:
    rays = rays_within(min(reach_deg, 80.0))
    K, zero = np.eye(3), np.zeros(3)
    if isinstance(lens, Equidistant):
        expected, _ = cv2.fisheye.projectPoints(rays[None], zero, zero, K, lens.coefficients)
        expected = expected[0]
    else:
        expected = cv2.projectPoints(rays, zero, zero, K, lens.coefficients)[0][:, 0]
    np.testing.assert_allclose(lens.project(rays), expected, atol=1e-12)


@each_lens
def test_the_inverse_gives_the_ray_back(lens: Lens, reach_deg: float) -> None:
    rays = np.vstack([rays_within(reach_deg), [[0.0, 0.0, 300.0]]])
    back = lens.unproject(lens.project(rays))
    along = np.linalg.norm(back, axis=1) * np.linalg.norm(rays, axis=1)
    np.testing.assert_allclose(np.sum(back * rays, axis=1), along, rtol=1e-14)
    np.testing.assert_allclose(np.cross(back, rays), 0.0, atol=1e-7)


@each_lens
def test_its_slopes_are_those_of_central_differences(lens: Lens, reach_deg: float) -> None:
    rays = np.vstack([rays_within(reach_deg, 30) / 100.0, [[0.0, 0.0, 3.0]]])
    J = lens.jacobian(rays)
    for k, step in enumerate(1e-6 * np.eye(3)):
        difference = (lens.project(rays + step) - lens.project(rays - step)) / 2e-6
        np.testing.assert_allclose(J[..., k], difference, atol=1e-8)


@each_lens
def test_its_slopes_by_the_coefficients_are_those_of_central_differences(lens: Lens, reach_deg: float) -> None:
    rays = rays_within(0.8 * reach_deg, 30)
    J = lens.coefficient_jacobian(rays)
    for k, step in enumerate(1e-6 * np.eye(len(lens.names))):
        difference = (lens.changed(step).project(rays) - lens.changed(-step).project(rays)) / 2e-6
        np.testing.assert_allclose(J[..., k], difference, atol=1e-7)


@each_lens
def test_rays_farther_out_land_farther_out_up_to_the_limit(lens: Lens, reach_deg: float) -> None:
    assert lens.limit_rad > np.radians(reach_deg)
    theta = np.linspace(0.0, lens.limit_rad * 0.999, 500)
    radial = lens.changed(np.array([0.0 if name[0] in "pst" else value for name, value in lens.named.items()]))
    radial = type(lens)(radial.coefficients - lens.coefficients)
    places = radial.project(np.stack([np.sin(theta), np.zeros(500), np.cos(theta)], axis=-1))
    assert np.all(np.diff(places[:, 0]) > 0.0)


def test_table_2_folds_at_a_radius_of_0_66() -> None:
    assert np.tan(PlumbBob(TABLE_2).limit_rad) == pytest.approx(0.658, abs=0.002)


def test_a_lens_without_a_fold_sees_all_that_its_kind_can() -> None:
    assert PlumbBob(np.zeros(5)).limit_rad == pytest.approx(np.pi / 2)
    assert Equidistant(np.zeros(4)).limit_rad == pytest.approx(np.pi)


@each_lens
def test_a_place_that_no_ray_reaches_has_no_ray(lens: Lens, reach_deg: float) -> None:
    assert np.isnan(lens.unproject(np.array([[50.0, 0.0], [np.nan, 0.1]]))).all()


def test_coefficients_of_another_model_are_a_programming_error() -> None:
    with pytest.raises(ValueError, match="plumb_bob has 5"):
        PlumbBob(np.zeros(4))
