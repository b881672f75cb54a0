"""The camera's assumed orientation is off for all of the recording.

A turn about the optical axis looks like a turned base and is left to the geometry; what remains is the keystone of the
turns about the camera's x and y axes.

Known forms: a board that was not where it was thought to be when the camera was calibrated, a mount that was turned
since, a rolling shutter's shear (not covered). Covered: fixed turns about the camera's x and y axes.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from armtwin.models.camera import Camera
from armtwin.models.catalogue import sealed
from armtwin.models.catalogue.camera_path import CameraPath
from armtwin.models.catalogue.context import Context
from armtwin.models.catalogue.injection import Injected
from armtwin.models.catalogue.registry import Effect, Parameter, Site, Stage
from armtwin.models.world import World

Array = NDArray[np.float64]


def term(context: Context, path: CameraPath, values: Array, site: Site) -> CameraPath:
    """Camera turned about its own x and y axes."""
    return path.turned(np.array([[values[0], values[1], 0.0]]), np.zeros((1, 3)))


def _parameters(context: Context, site: Site) -> tuple[Parameter, ...]:
    return (Parameter("tilt_x_rad", (-0.3, 0.3), 0.03), Parameter("tilt_y_rad", (-0.3, 0.3), 0.03))


def _starts(context: Context, site: Site, around: Array | None) -> Iterable[Array]:
    return [] if around is not None else [np.zeros(2)]


# --- how the simulated bench makes it ---


def inject(world: World, parameters: Mapping[str, Any], site: Site) -> World:
    """Turn the camera about its own centre, after it was calibrated, by a rotation vector in its axes.

    `tilt_x_rad`, `tilt_y_rad`, `tilt_z_rad`; a missing one is 0.
    """
    tilt = [float(parameters[f"tilt_{axis}_rad"]) for axis in "xyz"]
    turned = world.true_camera.moved(Rotation.from_rotvec(tilt).as_matrix(), np.zeros(3))
    return replace(world, true_camera=turned)


def _hide(rng: Generator, s: sealed.Situation) -> sealed.Hidden:
    """Draw how it is hidden in a sealed world."""
    x, y = sealed.direction(rng, 2)
    return sealed.Hidden(lambda a: {"tilt_x_rad": a * x, "tilt_y_rad": a * y}, 0.02, 0.05)


def _left(assumed: Camera, true: Camera) -> dict[str, float]:
    turn = Rotation.from_matrix(true.R_board_camera @ assumed.R_board_camera.T).as_rotvec()
    return {"tilt_x_rad": float(turn[0]), "tilt_y_rad": float(turn[1])}


EFFECT = Effect(
    name="camera_tilt",
    summary="the camera's assumed orientation is off for all of the recording",
    where="camera",
    stage=Stage.CAMERA,
    parameters=_parameters,
    term=term,
    starts=_starts,
    injector=inject,
    injected=tuple(Injected(f"tilt_{axis}_rad", (-1.0, 1.0), 0.0) for axis in "xyz"),
    confused_with=("axis_tilt", "lens_distortion", "focal_length"),
    experiment="the camera moved to another place and calibrated there; a gauge laid across the plane",
    needs_camera=True,
    left_by_calibration=_left,
    plans=("camera_elsewhere", "gauge_in_plane"),
    sealed=sealed.Sealing(_hide),
)
