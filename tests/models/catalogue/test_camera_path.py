"""Departures of a camera add up sample by sample."""

import numpy as np
from scipy.spatial.transform import Rotation

from armtwin.models.camera import project
from armtwin.models.camera_files import nominal_camera
from armtwin.models.catalogue.camera_path import CameraPath

POINTS = np.random.default_rng(0).uniform([-150, -50, -85], [150, 120, -75], (6, 4, 3))


def test_as_assumed_it_projects_as_the_camera_does() -> None:
    seen = CameraPath.as_assumed().project(nominal_camera(), POINTS)
    np.testing.assert_allclose(seen.reshape(-1, 2), project(nominal_camera(), POINTS.reshape(-1, 3)), atol=1e-9)


def test_each_sample_has_its_own_turn_and_shift() -> None:
    camera = nominal_camera()
    rng = np.random.default_rng(1)
    turns, shifts = rng.normal(0.0, 0.05, (6, 3)), rng.normal(0.0, 5.0, (6, 3))
    seen = CameraPath.as_assumed().turned(turns, shifts).project(camera, POINTS)
    for row in range(6):
        moved = camera.moved(Rotation.from_rotvec(turns[row]).as_matrix(), shifts[row])
        np.testing.assert_allclose(seen[row], project(moved, POINTS[row]), atol=1e-6)


def test_zooms_multiply_and_distortions_add() -> None:
    path = CameraPath.as_assumed().zoomed(np.array([1.1])).zoomed(np.array([0.9])).distorted(np.ones(5))
    np.testing.assert_allclose(path.focal_scale, [0.99])
    np.testing.assert_allclose(path.distorted(np.ones(5)).distortion, np.full(5, 2.0))


def test_slopes_are_the_derivative_of_the_projection() -> None:
    rng = np.random.default_rng(2)
    path = CameraPath.as_assumed().turned(rng.normal(0.0, 0.05, (6, 3)), rng.normal(0.0, 5.0, (6, 3)))
    path = path.zoomed(np.linspace(0.98, 1.02, 6)).distorted(np.array([0.05, -0.1, 0.002, -0.001, 0.1]))
    camera, directions = nominal_camera(), rng.normal(size=(2, 3))
    slopes = path.slopes(camera, POINTS, directions)
    for slope, direction in zip(slopes, directions, strict=True):
        ahead, behind = (path.project(camera, POINTS + step * direction) for step in (1e-4, -1e-4))
        np.testing.assert_allclose(slope, (ahead - behind) / 2e-4, rtol=1e-6, atol=1e-6)
