"""The paper's detector: each stage is what section 3.2 says, and its centres are good to a pixel or two."""

from __future__ import annotations

import numpy as np
import pytest

from armtwin.calib.markers import PaperStages, detect, paper_stages
from armtwin.models.camera import Camera
from tests.support.discs import Image, draw_discs, places_of, take, true_pixels

PIXELS = np.array([[300.0, 200.0], [640.0, 360.0], [900.0, 500.0], [1000.0, 150.0]])


@pytest.fixture(scope="module")
def image(webcam: Camera) -> Image:
    rng = np.random.default_rng(2)
    return take(draw_discs(webcam, places_of(webcam, PIXELS), 7.0), 2.0, rng)


@pytest.fixture(scope="module")
def stages(image: Image) -> PaperStages:
    return paper_stages(image)


def test_the_first_stage_is_the_red_channel(image: Image, stages: PaperStages) -> None:
    assert np.array_equal(stages.red, image[..., 2])


def test_smoothing_takes_noise_away(stages: PaperStages) -> None:
    assert stages.smooth[600:, :200].std() < 0.5 * stages.red[600:, :200].std()


def test_each_sobel_stage_sees_its_own_direction(webcam: Camera, stages: PaperStages) -> None:
    u, v = np.rint(true_pixels(webcam, places_of(webcam, PIXELS))[1]).astype(int)
    right, below = (v, u + 20), (v + 20, u)
    assert stages.gradient_u[right] > 5 * stages.gradient_u[below]
    assert stages.gradient_v[below] > 5 * stages.gradient_v[right]
    assert min(stages.gradient[right], stages.gradient[below]) > 150


def test_the_binary_stage_is_the_outlines(stages: PaperStages) -> None:
    assert set(np.unique(stages.binary)) == {0, 255}
    assert 0.003 < (stages.binary > 0).mean() < 0.03


def test_opening_removes_points_and_keeps_outlines(image: Image) -> None:
    spotted = image.copy()
    spotted[650, 100] = 255
    stages = paper_stages(spotted)
    assert stages.opened[640:660, 90:110].max() == 0
    assert (stages.opened > 0).sum() > 0.9 * (paper_stages(image).opened > 0).sum()


def test_the_transform_finds_each_disc_to_a_pixel_or_two(webcam: Camera, image: Image) -> None:
    truth = true_pixels(webcam, places_of(webcam, PIXELS))
    truth = truth[np.argsort(truth[:, 0])]
    discs = detect(image, "paper", webcam)
    assert len(discs) == 4
    error = np.stack([d.centre for d in discs]) - truth
    assert 0.1 < np.sqrt(np.mean(error**2)) < 2.5


def test_it_gives_no_standard_deviation(image: Image) -> None:
    assert all(np.isnan(d.covariance).all() for d in detect(image, "paper"))


def test_an_empty_picture_has_no_circles() -> None:
    assert detect(np.zeros((720, 1280, 3), np.uint8), "paper") == ()


def test_subpixel_is_twenty_times_nearer_to_the_truth_on_the_same_frames(webcam: Camera) -> None:
    rng = np.random.default_rng(3)
    squares = {"paper": [], "subpixel": []}
    for _ in range(5):
        places = places_of(webcam, PIXELS + rng.uniform(-20.0, 20.0, PIXELS.shape))
        frame, truth = take(draw_discs(webcam, places, 7.0), 2.0, rng), true_pixels(webcam, places)
        for method, found in squares.items():
            centres = np.stack([d.centre for d in detect(frame, method, webcam)])
            nearest = np.linalg.norm(centres[None] - truth[:, None], axis=2).min(axis=1)
            found.extend(nearest[nearest < 10.0] ** 2)
    assert len(squares["subpixel"]) == 20
    assert np.sqrt(np.mean(squares["paper"])) > 20.0 * np.sqrt(np.mean(squares["subpixel"]))
