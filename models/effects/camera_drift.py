"""The camera creeps.

The term is a creep along the recording's clock that slows down with a time constant of `settling` recordings.

Known forms: a tripod or a clamp that settles, a mount that warms up (both slow down), a thread that goes on turning.
Covered: one creep of all six motions with one time constant, from a step to a steady crawl. Not covered: a drift
there and back, and breathing with the room's temperature.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
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
from armtwin.models.world import Moment, World

Array = NDArray[np.float64]


def term(context: Context, path: CameraPath, values: Array, site: Site) -> CameraPath:
    """Camera that has turned and shifted by `values[:6]` at the end."""
    along = np.expm1(-context.clock / values[6])[:, None] / np.expm1(-1.0 / values[6])
    return path.turned(along * values[:3], along * values[3:6])


def _parameters(context: Context, site: Site) -> tuple[Parameter, ...]:
    return (
        *(Parameter(f"rotation_{axis}_rad", (-0.3, 0.3), 0.02) for axis in "xyz"),
        *(Parameter(f"translation_{axis}_mm", (-100.0, 100.0), 10.0) for axis in "xyz"),
        Parameter("settling", (0.03, 30.0), 3.0, off=None),
    )


def _starts(context: Context, site: Site, around: Array | None) -> Iterable[Array]:
    if around is not None:
        return []
    return [np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, settling]) for settling in (0.2, 3.0)]


# --- how the simulated bench makes it ---


# Plastics creep with the logarithm of time; a clamp that was closed two recordings ago still slows down a little.
_CLOSED_AGO = 2.0


def inject(world: World, parameters: Mapping[str, Any], site: Site) -> World:
    """Let the camera's clamp creep from the first picture on.

    `rotation_x_rad`, ... and `translation_x_mm`, ... are what it has come to at the last picture, in the camera's
    axes as for a bump; a missing one is 0. `settling` is how long ago, in recordings, the clamp was closed.
    """
    age = float(parameters["settling"])
    turn = np.array([float(parameters[f"rotation_{axis}_rad"]) for axis in "xyz"])
    shift = np.array([float(parameters[f"translation_{axis}_mm"]) for axis in "xyz"])

    def creep(camera: Camera, moment: Moment) -> Camera:
        share = math.log1p(moment.progress / age) / math.log1p(1.0 / age)
        return camera.moved(Rotation.from_rotvec(share * turn).as_matrix(), share * shift)

    return world.with_camera_motion(creep)


def _hide(rng: Generator, s: sealed.Situation) -> sealed.Hidden:
    """Draw how it is hidden in a sealed world."""
    return sealed.Hidden(sealed.camera_motion(rng), 0.002, 0.04)


EFFECT = Effect(
    name="camera_drift",
    summary="the camera creeps",
    where="camera",
    stage=Stage.CAMERA,
    parameters=_parameters,
    term=term,
    starts=_starts,
    injector=inject,
    injected=(
        *(Injected(f"rotation_{axis}_rad", (-1.0, 1.0), 0.0) for axis in "xyz"),
        *(Injected(f"translation_{axis}_mm", (-400.0, 400.0), 0.0) for axis in "xyz"),
        Injected("settling", (0.01, 1000.0), _CLOSED_AGO),
    ),
    confused_with=("camera_moved", "thermal_drift"),
    experiment="one pose repeated now and then over a long time; marker A tells the camera from the arm",
    needs_camera=True,
    plans=("repeat_pose",),
    needs_return=True,
    in_time=True,
    sealed=sealed.Sealing(_hide),
)
