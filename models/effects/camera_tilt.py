"""The camera's assumed orientation is off for all of the recording.

A turn about the optical axis looks like a turned base and is left to the geometry; what remains is the keystone of the
turns about the camera's x and y axes.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from models.effects.camera_path import CameraPath
from models.effects.context import Context
from models.effects.pixels import needs_camera
from models.effects.registry import Effect, Parameter, Site, Stage

Array = NDArray[np.float64]


def term(context: Context, path: CameraPath, values: Array, site: Site) -> CameraPath:
    """Camera turned about its own x and y axes."""
    return path.turned(np.array([[values[0], values[1], 0.0]]), np.zeros((1, 3)))


def _parameters(context: Context, site: Site) -> tuple[Parameter, ...]:
    return (Parameter("tilt_x_rad", (-0.3, 0.3), 0.03), Parameter("tilt_y_rad", (-0.3, 0.3), 0.03))


def _starts(context: Context, site: Site, around: Array | None) -> Iterable[Array]:
    return [] if around is not None else [np.zeros(2)]


# --- how the simulated bench makes it ---


def inject(world: Any, parameters: Mapping[str, Any], joint: int | None = None, marker: str | None = None) -> Any:
    """To be written by the physics engineer."""
    raise NotImplementedError


EFFECT = Effect(
    name="camera_tilt",
    summary="the camera's assumed orientation is off for all of the recording",
    where="camera",
    stage=Stage.CAMERA,
    parameters=_parameters,
    term=term,
    starts=_starts,
    inject=inject,
    confused_with=("axis_tilt", "lens_distortion", "focal_length"),
    experiment="the camera moved to another place and calibrated there; a gauge laid across the plane",
    applies=needs_camera,
    plans=("camera_elsewhere", "gauge_in_plane"),
)
