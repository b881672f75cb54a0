"""The evaluation of section 5.1.1: the statistics of Table 3, and what both detectors make of drawn gauges."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from armtwin.calib.gauges import PAPER_TABLE_3, evaluate, measure_gauge, measure_gauges
from armtwin.models.camera import Camera
from armtwin.models.camera_files import nominal_camera
from armtwin.models.errors import InputError
from tests.support.discs import PLANE_MM, Image, draw_discs, places_of, take

Array = NDArray[np.float64]

PLACEMENTS = 20


@pytest.fixture(scope="module")
def webcam() -> Camera:
    return nominal_camera()


def drawn(webcam: Camera, length_mm: float, radius_mm: float, rng: np.random.Generator) -> Image:
    """A gauge somewhere in the picture, turned anyhow."""
    middle = places_of(webcam, rng.uniform([200.0, 150.0], [1080.0, 570.0])[None])[0]
    angle = rng.uniform(0.0, 2.0 * np.pi)
    half = 0.5 * length_mm * np.array([np.cos(angle), np.sin(angle)])
    return take(draw_discs(webcam, np.stack([middle - half, middle + half]), radius_mm, blur_px=0.8), 2.0, rng)


def test_a_row_holds_the_mean_bias_mean_square_error_and_equation_24() -> None:
    (row,) = evaluate({10.0: [10.1, 10.3, 10.2, np.nan]})
    assert (row.n, row.missed) == (3, 1)
    assert row.average_mm == pytest.approx(10.2)
    assert row.bias_mm == pytest.approx(0.2)
    assert row.mean_square_error_mm2 == pytest.approx((0.01 + 0.09 + 0.04) / 3.0)
    assert row.uncertainty_mm == pytest.approx(0.1)


@pytest.mark.parametrize("row", PAPER_TABLE_3)
def test_table_3_s_mean_square_error_is_bias_and_uncertainty_together(row: object) -> None:
    expected = row.bias_mm**2 + row.uncertainty_mm**2 * (row.n - 1) / row.n
    assert row.mean_square_error_mm2 == pytest.approx(expected, abs=1e-4)


def test_rows_come_longest_first() -> None:
    assert [row.length_mm for row in evaluate({5.0: [5, 5.1], 40.0: [40, 40.1]})] == [40.0, 5.0]


def test_one_measurement_has_no_uncertainty() -> None:
    with pytest.raises(InputError, match="gauge of 5 mm: found in 1 of 2 pictures; at least 2"):
        evaluate({5.0: [5.0, np.nan]})


@pytest.mark.parametrize(("length_mm", "radius_mm"), [(40.0, 6.0), (30.0, 6.0), (10.0, 3.0), (5.0, 1.5)])
def test_subpixel_measures_every_gauge_within_three_hundredths(
    webcam: Camera, length_mm: float, radius_mm: float
) -> None:
    rng = np.random.default_rng(int(length_mm))
    images = [drawn(webcam, length_mm, radius_mm, rng) for _ in range(PLACEMENTS)]
    (row,) = evaluate(
        {length_mm: measure_gauges(images, length_mm, radius_mm, webcam, PLANE_MM, ["subpixel"])["subpixel"]}
    )
    assert row.missed == 0
    assert abs(row.bias_mm) < 0.03
    assert row.uncertainty_mm < 0.03


def test_both_detectors_see_the_same_images(webcam: Camera) -> None:
    rng = np.random.default_rng(1)
    measured = measure_gauges((drawn(webcam, 30.0, 6.0, rng) for _ in range(8)), 30.0, 6.0, webcam, PLANE_MM)
    assert {method: len(values) for method, values in measured.items()} == {"paper": 8, "subpixel": 8}
    errors = {method: np.sqrt(np.nanmean((values - 30.0) ** 2)) for method, values in measured.items()}
    assert errors["paper"] > 10.0 * errors["subpixel"]


def test_a_picture_without_the_gauge_is_not_measured(webcam: Camera) -> None:
    image = take(draw_discs(webcam, places_of(webcam, np.array([[300.0, 300.0]])), 6.0))
    assert np.isnan(measure_gauge(image, 30.0, 6.0, webcam, PLANE_MM))
