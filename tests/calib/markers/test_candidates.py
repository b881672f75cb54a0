"""Where discs may be, among other things."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from armtwin.calib.markers.candidates import find_candidates
from armtwin.calib.markers.disc import DetectorConfig
from armtwin.models.camera import Camera
from armtwin.models.errors import InputError
from tests.support.discs import Image, draw_discs, places_of, take, true_pixels

PIXELS = np.array([[300.0, 200.0], [900.0, 500.0]])
SETTINGS = DetectorConfig()


def picture(webcam: Camera, **drawn: float) -> tuple[Image, np.ndarray]:
    places = places_of(webcam, PIXELS)
    return take(draw_discs(webcam, places, 7.0, **drawn)), true_pixels(webcam, places)


@pytest.mark.parametrize("drawn", [{}, {"blur_px": 3.0}, {"face": 70.0, "ground": 8.0}, {"face": 255.0}])
def test_first_ellipses_are_within_a_pixel(webcam: Camera, drawn: dict[str, float]) -> None:
    image, truth = picture(webcam, **drawn)
    found = sorted(find_candidates(image, SETTINGS), key=lambda c: float(c.centre[0]))
    assert np.stack([c.centre for c in found]) == pytest.approx(truth, abs=1.0)
    assert all(c.radius == pytest.approx(20.5, abs=1.5) for c in found)


def test_white_and_grey_things_are_no_candidates(webcam: Camera) -> None:
    image, _ = picture(webcam)
    cv2.circle(image, (600, 300), 20, (230, 230, 230), -1)
    cv2.rectangle(image, (100, 600), (400, 700), (120, 120, 120), -1)
    assert len(find_candidates(image, SETTINGS)) == 2


def test_a_long_red_thing_hides_no_disc_and_is_none(webcam: Camera) -> None:
    image, _ = picture(webcam)
    cv2.rectangle(image, (0, 650), (1279, 719), (20, 20, 120), -1)
    assert len(find_candidates(image, SETTINGS)) == 2


def test_a_disc_with_a_bite_taken_out_of_it_is_found_round(webcam: Camera) -> None:
    image, truth = picture(webcam)
    cv2.rectangle(image, (round(truth[0, 0]) + 8, 150), (400, 250), (15, 15, 25), -1)
    found = min(find_candidates(image, SETTINGS), key=lambda c: float(c.centre[0]))
    assert found.centre == pytest.approx(truth[0], abs=2.0)


def test_a_grey_picture_is_searched_as_it_is(webcam: Camera) -> None:
    image, _ = picture(webcam)
    assert len(find_candidates(np.ascontiguousarray(image[..., 2]), SETTINGS)) == 2


def test_a_picture_of_floats_is_refused() -> None:
    with pytest.raises(InputError, match="8 bits; found"):
        find_candidates(np.zeros((10, 10, 3)), SETTINGS)  # type: ignore[arg-type]
