"""A film of a moving arm: what moves while light is gathered is blurred, its middle stays where it was midway."""

import cv2
import numpy as np
import pytest

from armtwin.calib.markers import detect
from armtwin.models.arm import nominal_arm
from armtwin.models.bench import FilmingBench
from armtwin.models.camera_files import nominal_camera
from armtwin.models.motion_arm import planar_arm
from armtwin.models.motion_world import ideal_motion_world
from armtwin.models.world import ideal_world
from armtwin.sim.bench import SimulatedBench
from armtwin.sim.motion.film import Film, FilmedArm
from armtwin.sim.sensor import Sensor

PLANE_MM = -80.87
FAST_RAD_S = 2.0


def sharpness(image: np.ndarray, at: np.ndarray) -> float:
    u, v = np.round(at).astype(int)
    part = cv2.cvtColor(image[v - 30 : v + 30, u - 30 : u + 30], cv2.COLOR_BGR2GRAY)
    return float(cv2.Laplacian(part, cv2.CV_64F).var())


def sweeping(exposure_s: float) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """The truth and the picture of an arm that sweeps at 2 rad/s."""
    arm, camera = nominal_arm(), nominal_camera()
    world = ideal_world(arm, camera, PLANE_MM, np.array([40.0, -33.0]))
    time_s = np.arange(0.0, 0.6, 0.01)
    q = np.stack([-0.4 + FAST_RAD_S * time_s, 0.0 * time_s, 0.0 * time_s], axis=-1)
    filmed = FilmedArm(world, ideal_motion_world(planar_arm(arm)), time_s, np.clip(q, -0.4, 0.4))
    quiet = Sensor(full_well_electrons=0.0, read_noise_electrons=0.0, exposure_time_s=exposure_s)
    film = Film(filmed, quiet, np.random.default_rng(0), shadows=False)
    try:
        frame = film.frame(0.25)
        return film.true_pixels(), frame.image
    finally:
        film.close()


def off_px(exposure_s: float) -> float:
    """How far from the tip's mean place the nearest disc is found that the detector takes for a marker."""
    truth, image = sweeping(exposure_s)
    found = np.array([disc.centre for disc in detect(image, "subpixel", nominal_camera(), PLANE_MM)])
    return float(np.linalg.norm(found - truth["f"], axis=1).min())


@pytest.mark.parametrize(("exposure_s", "most_px"), [(0.0, 0.02), (0.004, 0.06), (0.012, 0.25)])
def test_markers_of_a_blurred_picture_are_measured_where_they_were_on_the_mean(
    exposure_s: float, most_px: float
) -> None:
    assert off_px(exposure_s) < most_px


def test_a_marker_that_is_smeared_past_its_own_width_is_not_found_instead_of_found_wrongly() -> None:
    assert off_px(0.020) > 20.0


def test_a_longer_exposure_blurs_more() -> None:
    truths, pictures = zip(*(sweeping(seconds) for seconds in (0.0, 0.020)), strict=True)
    assert sharpness(pictures[1], truths[1]["f"]) < 0.8 * sharpness(pictures[0], truths[0]["f"])


def test_the_simulated_bench_films_a_picture_a_command_at_its_time() -> None:
    bench = SimulatedBench(ideal_world(nominal_arm(), nominal_camera(), PLANE_MM))
    assert isinstance(bench, FilmingBench)
    time_s = np.arange(3) / 30.0
    with bench:
        frames = list(bench.film(time_s, np.zeros((3, 3))))
    assert [frame.time_s for frame in frames] == pytest.approx(time_s.tolist())
    assert all(frame.commanded_s == frame.time_s for frame in frames)
