"""The default detector against the truth: bias, bound, covariance, covers, clutter."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from armtwin.calib.markers import Disc, centre_bound, detect
from armtwin.models.camera import Camera
from tests.support.discs import FACE, GROUND, PLANE_MM, Image, draw_discs, places_of, take, true_pixels

Array = NDArray[np.float64]

RADIUS_MM = 7.0
# Over the picture, corners included.
SPREAD = np.array([[80.0, 70.0], [640.3, 360.7], [1190.2, 80.5], [90.6, 640.1], [1200.4, 630.9], [400.8, 500.2]])


def errors(discs: tuple[Disc, ...], truth: Array) -> Array:
    """(N, 2) error of the only disc near each true centre."""
    near = [[d.centre - t for d in discs if np.linalg.norm(d.centre - t) < 15.0] for t in truth]
    assert [len(found) for found in near] == [1] * len(truth)
    return np.array(near)[:, 0]


@pytest.mark.parametrize("blur_px", [0.5, 1.0, 3.0])
def test_without_noise_centres_are_right_all_over_the_picture(webcam: Camera, blur_px: float) -> None:
    places = places_of(webcam, SPREAD)
    image = take(draw_discs(webcam, places, RADIUS_MM, blur_px=blur_px))
    error = errors(detect(image, camera=webcam), true_pixels(webcam, places))
    assert np.abs(error).max() < 0.01
    assert np.abs(error.mean(axis=0)).max() < 0.003


def test_the_ellipse_s_centre_of_a_tilted_disc_is_corrected(tilted: Camera) -> None:
    places = places_of(tilted, SPREAD[1:4], 0.0)
    image, truth = take(draw_discs(tilted, places, 10.0, 0.0)), true_pixels(tilted, places, 0.0)
    assert np.abs(errors(detect(image, camera=tilted), truth)).max() < 0.01
    assert np.abs(errors(detect(image), truth)).max() > 0.05  # what a detector without a camera must get wrong


def test_any_parallel_plane_gives_the_same_centres(webcam: Camera) -> None:
    image = take(draw_discs(webcam, places_of(webcam, SPREAD), RADIUS_MM))
    one, other = (detect(image, camera=webcam, plane_z_mm=z) for z in (0.0, PLANE_MM))
    assert np.stack([d.centre for d in one]) == pytest.approx(np.stack([d.centre for d in other]), abs=1e-6)


def scatter(webcam: Camera, rng: np.random.Generator, blur_px: float, noise: float, n: int = 24) -> tuple[Array, Array]:
    """(4 n, 2) errors and (4 n, 2, 2) covariances of four discs in `n` pictures that differ in noise."""
    places = places_of(webcam, SPREAD[1:5])
    clean, truth = draw_discs(webcam, places, RADIUS_MM, blur_px=blur_px), true_pixels(webcam, places)
    all_errors, all_covariances = [], []
    for _ in range(n):
        discs = sorted(detect(take(clean, noise, rng), camera=webcam), key=lambda d: float(d.centre[0]))
        order = np.argsort(truth[:, 0])
        all_errors.append(errors(tuple(discs), truth[order]))
        all_covariances.append(np.stack([d.covariance for d in discs]))
    return np.concatenate(all_errors), np.concatenate(all_covariances)


@pytest.mark.parametrize(("blur_px", "noise"), [(0.7, 2.0), (1.0, 8.0), (3.0, 2.0)])
def test_errors_are_near_the_bound_and_the_covariance_tells_them(
    webcam: Camera, rng: np.random.Generator, blur_px: float, noise: float
) -> None:
    error, covariance = scatter(webcam, rng, blur_px, noise)
    # 21 px is the radius in the middle of the picture, the smallest of the four.
    bound = centre_bound(20.4, FACE - GROUND, blur_px, noise)
    assert np.sqrt(np.mean(error**2)) < 1.5 * bound
    # Mean squared standardised error: 1 where the covariance is right; 192 coordinates know it to 10 %.
    standardised = np.einsum("ni,nij,nj->n", error, np.linalg.inv(covariance), error).mean() / 2.0
    assert 0.3 < standardised < 1.4


def test_vignetting_moves_no_centre(webcam: Camera) -> None:
    places = places_of(webcam, SPREAD)
    image = take(draw_discs(webcam, places, RADIUS_MM), vignetting=0.4)
    assert np.abs(errors(detect(image, camera=webcam), true_pixels(webcam, places))).max() < 0.02


@pytest.mark.parametrize("levels", [(70.0, 8.0), (255.0, 40.0)])
def test_exposure_moves_no_centre(webcam: Camera, levels: tuple[float, float]) -> None:
    places = places_of(webcam, SPREAD)
    image = take(draw_discs(webcam, places, RADIUS_MM, face=levels[0], ground=levels[1]))
    assert np.abs(errors(detect(image, camera=webcam), true_pixels(webcam, places))).max() < 0.02


def covered(webcam: Camera, rng: np.random.Generator, kind: str, depth: float, angle: float) -> tuple[Image, Array]:
    """A disc behind a dark half-plane, or a cable 8 px wide, that begins, or runs, `depth` px from its centre."""
    places = places_of(webcam, SPREAD[1:2])
    truth = true_pixels(webcam, places)
    sharp = draw_discs(webcam, places, RADIUS_MM, blur_px=0.0)
    v, u = np.mgrid[: sharp.shape[0], : sharp.shape[1]]
    along = (u - truth[0, 0]) * np.cos(angle) + (v - truth[0, 1]) * np.sin(angle) - depth
    share = np.clip(0.5 + (along if kind == "half-plane" else 4.0 - np.abs(along)), 0.0, 1.0)
    return take(cv2.GaussianBlur(sharp * (1.0 - share) + 15.0 * share, (0, 0), 1.0), 2.0, rng), truth[0]


@pytest.mark.parametrize("kind", ["half-plane", "cable"])
def test_a_covered_disc_is_missing_or_its_covariance_tells(webcam: Camera, rng: np.random.Generator, kind: str) -> None:
    found = 0
    for depth in np.linspace(-14.0, 19.0, 12):
        image, truth = covered(webcam, rng, kind, depth, rng.uniform(0.0, 2.0 * np.pi))
        for disc in detect(image, camera=webcam):
            if disc.axes[0] > 15.0:  # a sliver may look like a small disc: `identify` compares sizes
                found += 1
                error = disc.centre - truth
                assert np.sqrt(error @ np.linalg.solve(disc.covariance, error)) < 6.0
                assert np.linalg.norm(error) < 0.5
    assert found >= 4


def test_a_disc_of_which_little_is_seen_is_not_reported(webcam: Camera, rng: np.random.Generator) -> None:
    image, _ = covered(webcam, rng, "half-plane", -8.0, 0.7)
    assert not [d for d in detect(image, camera=webcam) if d.axes[0] > 15.0]


def test_a_disc_cut_by_the_border_is_seen_in_part_or_not_at_all(webcam: Camera) -> None:
    places = places_of(webcam, np.array([[-8.0, 300.0], [1268.0, 420.0]]))
    image, truth = take(draw_discs(webcam, places, RADIUS_MM)), true_pixels(webcam, places)
    discs = detect(image, camera=webcam)
    assert not [d for d in discs if np.linalg.norm(d.centre - truth[0]) < 30.0]  # a third of it is in sight
    seen = next(d for d in discs if np.linalg.norm(d.centre - truth[1]) < 30.0)
    assert not seen.is_whole
    assert seen.centre == pytest.approx(truth[1], abs=0.1)


def test_red_things_that_are_not_round_are_no_discs(webcam: Camera) -> None:
    image = take(draw_discs(webcam, places_of(webcam, SPREAD[:1]), RADIUS_MM))
    cv2.rectangle(image, (300, 200), (340, 240), (30, 30, 200), -1)
    cv2.fillPoly(image, [np.array([[600, 500], [660, 500], [630, 550]])], (30, 30, 200))
    cv2.ellipse(image, (900, 300), (50, 15), 20.0, 0.0, 360.0, (30, 30, 200), -1)
    assert len(detect(image, camera=webcam)) == 1


def test_an_empty_picture_has_no_discs(webcam: Camera) -> None:
    assert detect(np.zeros((720, 1280, 3), np.uint8), camera=webcam) == ()


def test_a_turned_view_of_a_picture_is_read_as_its_copy(webcam: Camera) -> None:
    image = take(draw_discs(webcam, places_of(webcam, SPREAD), RADIUS_MM))[::-1, ::-1]
    view, copy = detect(image), detect(image.copy())
    assert len(view) == 6
    assert np.array_equal([d.centre for d in view], [d.centre for d in copy])


def test_the_same_picture_gives_the_same_bits(webcam: Camera, rng: np.random.Generator) -> None:
    image = take(draw_discs(webcam, places_of(webcam, SPREAD), RADIUS_MM), 4.0, rng)
    one, other = detect(image, camera=webcam), detect(image, camera=webcam)
    assert np.array_equal([d.centre for d in one], [d.centre for d in other])
