"""Marker measurement on rendered pictures: what the renderer draws and what the detector finds agree."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from armtwin.calib.gauges import evaluate, measure_gauges
from armtwin.calib.markers import detect, identify
from armtwin.models.arm import nominal_arm
from armtwin.models.camera import Camera, project
from armtwin.models.camera_files import nominal_camera
from armtwin.models.coordinate_frames import robot_to_board
from armtwin.models.kinematics import inverse, marker_positions
from armtwin.models.lenses import Equidistant
from armtwin.models.trajectories import circle
from armtwin.sim.render.arm_scene import arm_parts
from armtwin.sim.render.bench_scene import (
    GAUGE_LENGTHS_MM,
    clutter_parts,
    facing_camera,
    gauge_disc_radius_mm,
    gauge_parts,
    panel_parts,
)
from armtwin.sim.render.poses import planar_arm_poses, robot_bodies_on_board
from armtwin.sim.render.renderer import LensRenderer
from armtwin.sim.sensor.sensor import Sensor, expose
from tests.sim.render.field import disc_field, pixel_grid
from tests.support.discs import PLANE_MM, places_of

BASE_MM = np.array([40.0, -33.0, PLANE_MM])
PLACEMENTS = 20


@pytest.mark.parametrize("length_mm", GAUGE_LENGTHS_MM)
def test_subpixel_measures_rendered_gauges_within_three_hundredths(length_mm: float) -> None:
    camera, rng, images = nominal_camera(), np.random.default_rng(int(length_mm)), []
    with LensRenderer(camera, gauge_parts(length_mm) + panel_parts()) as renderer:
        for pixel in rng.uniform([250.0, 150.0], [1030.0, 570.0], (PLACEMENTS, 2)):
            pose = facing_camera(*places_of(camera, pixel[None])[0], PLANE_MM)
            pose[:3, :3] = pose[:3, :3] @ Rotation.from_euler("z", rng.uniform(0.0, 360.0), degrees=True).as_matrix()
            images.append(expose(renderer.render_linear({"gauge": pose}), Sensor(), rng))
    radius_mm = gauge_disc_radius_mm(length_mm)
    measured = measure_gauges(images, length_mm, radius_mm, camera, PLANE_MM, ["subpixel"])["subpixel"]
    (row,) = evaluate({length_mm: measured})
    assert row.missed == 0
    assert abs(row.bias_mm) < 0.03
    assert row.uncertainty_mm < 0.03


@pytest.mark.parametrize(
    ("sensor", "worst_px"),
    [
        (Sensor(), 0.03),
        (Sensor(blur_sigma_px=3.0), 0.06),
        (Sensor(exposure=0.35), 0.04),
        (Sensor(full_well_electrons=600.0), 0.08),
    ],
    ids=["default", "misfocused", "dark", "noisy"],
)
def test_markers_of_a_rendered_arm_are_named_and_right(sensor: Sensor, worst_px: float) -> None:
    arm, camera, rng = nominal_arm(), nominal_camera(), np.random.default_rng(5)
    q = inverse(arm, circle((-130.0, 40.0), 25.0, 5))
    parts = arm_parts(arm.link_lengths_mm) + panel_parts() + clutter_parts(BASE_MM)
    with LensRenderer(camera, parts, shadows=True) as renderer:
        for angles, places in zip(q, marker_positions(arm, q), strict=True):
            poses = robot_bodies_on_board(planar_arm_poses(arm.link_lengths_mm, angles), BASE_MM)
            image = expose(renderer.render_linear(poses), sensor, rng)
            reading = identify(detect(image, camera=camera, plane_z_mm=PLANE_MM), arm, camera, PLANE_MM, angles)
            assert reading.is_complete, reading.messages
            found = np.stack([reading.pixels[name] for name in arm.marker_names])
            assert found == pytest.approx(project(camera, robot_to_board(places, BASE_MM)), abs=worst_px)


def test_discs_are_found_where_they_are_through_a_fisheye() -> None:
    lens = Equidistant(np.array([0.0368, 0.0091, -0.0097, 0.001]))
    K = np.array([[320.0, 0.0, 318.3], [0.0, 321.0, 241.9], [0.0, 0.0, 1.0]])
    camera = Camera(640, 480, K, lens, np.diag([-1.0, -1.0, 1.0]), np.array([0.0, 0.0, 485.0]))
    parts, places, _ = disc_field(camera, pixel_grid(camera, 7, 5))
    with LensRenderer(camera, [*panel_parts(), *parts], supersampling=3) as renderer:
        found = detect(renderer.render({}), camera=camera)
    away = [np.linalg.norm(project(camera, places) - disc.centre, axis=1).min() for disc in found]
    assert len(found) >= 10
    assert max(away) < 0.03
