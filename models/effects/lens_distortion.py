"""The distortion coefficients do not fit the lens."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from armtwin.models.catalogue.camera_path import CameraPath
from armtwin.models.catalogue.context import Context
from armtwin.models.catalogue.injection import Injected
from armtwin.models.catalogue.pixels import needs_camera
from armtwin.models.catalogue.registry import Effect, Parameter, Site, Stage
from armtwin.models.world import World

Array = NDArray[np.float64]


# Physical priors: what a poor calibration of a webcam is off by.
_PRIORS = {"k1": 0.2, "k2": 0.6, "p1": 0.01, "p2": 0.01, "k3": 2.0}


def term(context: Context, path: CameraPath, values: Array, site: Site) -> CameraPath:
    """Camera whose coefficients differ by `values` (5,)."""
    return path.distorted(values)


def _parameters(context: Context, site: Site) -> tuple[Parameter, ...]:
    return tuple(Parameter(name, (-20 * std, 20 * std), std) for name, std in _PRIORS.items())


def _starts(context: Context, site: Site, around: Array | None) -> Iterable[Array]:
    return [] if around is not None else [np.zeros(5)]


# --- how the simulated bench makes it ---


def inject(world: World, parameters: Mapping[str, Any], joint: int | None = None, marker: str | None = None) -> World:
    """Put another lens on the camera: changes of `k1`, `k2`, `p1`, `p2`, `k3`; a missing one is 0."""
    change = np.array([float(parameters[name]) for name in ("k1", "k2", "p1", "p2", "k3")])
    return replace(world, true_camera=replace(world.true_camera, D=world.true_camera.D + change))


EFFECT = Effect(
    name="lens_distortion",
    summary="the distortion coefficients do not fit the lens",
    where="camera",
    stage=Stage.CAMERA,
    parameters=_parameters,
    term=term,
    starts=_starts,
    injector=inject,
    injected=tuple(Injected(name, (-20 * std, 20 * std), 0.0) for name, std in _PRIORS.items()),
    confused_with=("camera_tilt", "focal_length"),
    experiment="the arm spread over the whole picture, corners included; the board photographed there",
    applies=needs_camera,
    plans=("whole_picture",),
)
