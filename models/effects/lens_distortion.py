"""The distortion coefficients do not fit the lens.

Known forms: coefficients of another lens or another focus, a calibration that saw only the middle of the picture (Z.
Zhang, IEEE PAMI 22, 2000, on what its model holds), a lens of another model (fisheye for plumb bob). Covered: other
coefficients of the same model. Partly: another model, where its coefficients follow it over the arm's part of the
picture; elsewhere `unknown`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from armtwin.models.camera import Camera
from armtwin.models.catalogue import sealed
from armtwin.models.catalogue.camera_path import CameraPath
from armtwin.models.catalogue.context import Context
from armtwin.models.catalogue.injection import Injected
from armtwin.models.catalogue.registry import Effect, Parameter, Site, Stage
from armtwin.models.errors import InputError
from armtwin.models.lenses import Equidistant, Lens, no_distortion
from armtwin.models.world import World

Array = NDArray[np.float64]


# Physical priors: what a poor calibration of a webcam is off by. The rational model's lower polynomial trades against
# its upper one; a fisheye's coefficients multiply powers of an angle that reaches further than a pinhole's radius.
_PRIORS = {"k1": 0.2, "k2": 0.6, "p1": 0.01, "p2": 0.01, "k3": 2.0, "k4": 0.2, "k5": 0.6, "k6": 2.0}
_PRIORS |= dict.fromkeys(("s1", "s2", "s3", "s4", "tau_x", "tau_y"), 0.01)
_FISHEYE_PRIORS = {"k1": 0.05, "k2": 0.05, "k3": 0.05, "k4": 0.05}


def term(context: Context, path: CameraPath, values: Array, site: Site) -> CameraPath:
    """Camera whose lens has coefficients that differ by `values` (m,)."""
    return path.distorted(values)


def _parameters(context: Context, site: Site) -> tuple[Parameter, ...]:
    stds = _priors(_lens(context))
    return tuple(Parameter(name, (-20 * std, 20 * std), std) for name, std in stds.items())


def _starts(context: Context, site: Site, around: Array | None) -> Iterable[Array]:
    return [] if around is not None else [np.zeros(len(_lens(context).names))]


def _lens(context: Context) -> Lens:
    return no_distortion() if context.camera is None else context.camera.lens


def _priors(lens: Lens) -> dict[str, float]:
    stds = _FISHEYE_PRIORS if isinstance(lens, Equidistant) else _PRIORS
    return {name: stds[name] for name in lens.names}


# --- how the simulated bench makes it ---


def inject(world: World, parameters: Mapping[str, Any], site: Site) -> World:
    """Put another lens on the camera: changes of its coefficients by name; a missing one is 0."""
    camera = world.true_camera
    strange = [name for name in _PRIORS if name not in camera.lens.names and float(parameters.get(name, 0.0)) != 0.0]
    if strange:
        raise InputError(f"{strange[0]}: the lens of this camera has {', '.join(camera.lens.names)}; set one of those")
    change = np.array([float(parameters.get(name, 0.0)) for name in camera.lens.names])
    return replace(world, true_camera=replace(camera, lens=camera.lens.changed(change)))


def _hide(rng: Generator, s: sealed.Situation) -> sealed.Hidden:
    """Draw how it is hidden in a sealed world."""
    sign, p = sealed.sign(rng), 0.02 * sealed.direction(rng, 2)
    return sealed.Hidden(lambda a: {"k1": sign * a, "p1": a * p[0], "p2": a * p[1]}, 0.05, 0.5)


def _left(assumed: Camera, true: Camera) -> dict[str, float]:
    return {name: float(value - assumed.lens.named.get(name, 0.0)) for name, value in true.lens.named.items()}


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
    needs_camera=True,
    left_by_calibration=_left,
    plans=("whole_picture",),
    sealed=sealed.Sealing(_hide),
)
