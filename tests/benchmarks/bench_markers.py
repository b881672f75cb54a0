"""How long and how well discs are measured: `python tests/benchmarks/bench_markers.py`.

Four discs of 21 px in 1280 x 720 pictures, blurred and noisy, drawn by `tests/support/discs.py`; then rendered frames
of the arm on its bench. Targets for `subpixel`: 5 ms a frame, 1.5 times the Cramer-Rao bound, and at least 20 times
nearer to the truth than `paper` on the same frames. Times are processor time of one thread, least and median: other
jobs lengthen the median by what they take of cache and memory.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import cv2
import numpy as np
from numpy.typing import NDArray

from armtwin.calib.markers import DetectorConfig, Method, centre_bound, detect, identify
from armtwin.models.arm import nominal_arm
from armtwin.models.camera import project
from armtwin.models.camera_files import nominal_camera
from armtwin.models.coordinate_frames import robot_to_board
from armtwin.models.kinematics import inverse, marker_positions
from armtwin.models.trajectories import circle
from armtwin.sim.render.arm_scene import arm_parts
from armtwin.sim.render.bench_scene import clutter_parts, panel_parts
from armtwin.sim.render.poses import planar_arm_poses, robot_bodies_on_board
from armtwin.sim.render.renderer import LensRenderer
from armtwin.sim.sensor.sensor import Sensor, expose
from tests.support.discs import FACE, GROUND, PLANE_MM, draw_discs, places_of, take, true_pixels

Array = NDArray[np.float64]
Image = NDArray[np.uint8]

PIXELS = np.array([[300.0, 200.0], [640.0, 360.0], [900.0, 500.0], [1000.0, 150.0]])
RADIUS_MM, RADIUS_PX = 7.0, 20.5
BASE_MM = np.array([40.0, -33.0, PLANE_MM])
FRAMES = 30


def main() -> None:
    """Print a table a kind of picture."""
    cv2.setNumThreads(1)
    print("drawn discs            method   ms least median  RMS px   worst px  missed  RMS/bound  paper/subpixel")
    for blur_px, noise in [(0.7, 2.0), (1.0, 2.0), (1.0, 8.0), (2.0, 2.0), (3.0, 2.0)]:
        rng = np.random.default_rng(1)
        frames = [drawn(blur_px, noise, rng) for _ in range(FRAMES)]
        report(f"blur {blur_px} noise {noise}", frames, centre_bound(RADIUS_PX, FACE - GROUND, blur_px, noise))
    frames = rendered()
    print("rendered arm: default sensor, 50 poses of the paper's circle, clutter and shadows")
    report("bench", frames, float("nan"))
    arm, camera = nominal_arm(), nominal_camera()
    found = [detect(image, camera=camera, plane_z_mm=PLANE_MM) for image, _ in frames]
    spent = []
    for discs in found:
        start = time.thread_time()
        identify(discs, arm, camera, PLANE_MM, base_hint_mm=BASE_MM)
        spent.append(time.thread_time() - start)
    print(f"naming the markers of a frame: {1e3 * np.median(spent):.2f} ms")


def drawn(blur_px: float, noise: float, rng: np.random.Generator) -> tuple[Image, Array]:
    """A picture of four discs, and their true centres (4, 2)."""
    camera = nominal_camera()
    places = places_of(camera, PIXELS + rng.uniform(-20.0, 20.0, PIXELS.shape))
    return take(draw_discs(camera, places, RADIUS_MM, blur_px=blur_px), noise, rng), true_pixels(camera, places)


def rendered() -> list[tuple[Image, Array]]:
    """Frames of the arm on the paper's larger circle, and its markers' true pixels (4, 2)."""
    arm, camera, rng = nominal_arm(), nominal_camera(), np.random.default_rng(1)
    q = inverse(arm, circle((-130.0, 40.0), 25.0))
    parts = arm_parts(arm.link_lengths_mm) + panel_parts() + clutter_parts(BASE_MM)
    frames = []
    with LensRenderer(camera, parts, shadows=True) as renderer:
        for angles, places in zip(q, marker_positions(arm, q), strict=True):
            poses = robot_bodies_on_board(planar_arm_poses(arm.link_lengths_mm, angles), BASE_MM)
            image = expose(renderer.render_linear(poses), Sensor(), rng)
            frames.append((image, project(camera, robot_to_board(places, BASE_MM))))
    return frames


def report(name: str, frames: list[tuple[Image, Array]], bound: float) -> None:
    """Print time and errors of both detectors on the same frames."""
    squares: dict[str, Array] = {}
    for method in ("paper", "subpixel"):
        least, median, error, missed = measure(method, frames)
        squares[method] = error
        rms = np.sqrt(np.mean(error**2))
        line = f"{name:22s} {method:9s} {least:7.2f} {median:6.2f} {rms:8.4f} {error.max():9.3f} {missed:7d}"
        line += f" {rms / bound:9.2f}"
        ratio = np.sqrt(np.mean(squares["paper"] ** 2) / np.mean(error**2))
        print(line + (f" {ratio:13.0f}" if method == "subpixel" else ""))


def measure(method: Method, frames: list[tuple[Image, Array]]) -> tuple[float, float, Array, int]:
    """Least and median time, ms, errors of a coordinate, and how many discs were not found within ten pixels."""
    camera, spent, errors, missed = nominal_camera(), [], [], 0
    config = DetectorConfig(min_radius_px=12.0, max_radius_px=32.0)
    for image, truth in frames:
        start = time.thread_time()
        discs = detect(image, method, camera, PLANE_MM, config)
        spent.append(time.thread_time() - start)
        centres = np.array([disc.centre for disc in discs]).reshape(-1, 2)
        for place in truth:
            away = centres - place
            near = away[np.linalg.norm(away, axis=1) < 10.0]
            missed += not len(near)
            errors.extend(np.abs(near[:1]).ravel())
    return 1e3 * min(spent), 1e3 * float(np.median(spent)), np.array(errors), missed


if __name__ == "__main__":
    main()
