"""The focal length is off, or autofocus changed it.

For all of a recording it is nearly a scale of the plane, which longer links explain too; only distortion and tilt of
the camera tell. A change during the recording shows at once.

Known forms: a zoom ring that was touched, autofocus (focus breathing changes the field of view by some per cent), a
resolution that was cropped instead of scaled. Covered: one scale from one sample on, about the principal point. Not
covered: focus that hunts from picture to picture, and a crop that moves the principal point.
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
from armtwin.models.catalogue.injection import Injected, sample
from armtwin.models.catalogue.registry import Effect, Parameter, Site, Stage
from armtwin.models.catalogue.scan import event_rows, since
from armtwin.models.world import Moment, World

Array = NDArray[np.float64]


def term(context: Context, path: CameraPath, values: Array, site: Site) -> CameraPath:
    """Camera with its focal length times `scale` from `from_sample` on."""
    return path.zoomed(1.0 + (values[0] - 1.0) * since(context, values[1]))


def _parameters(context: Context, site: Site) -> tuple[Parameter, ...]:
    return (
        Parameter("scale", (0.7, 1.4), 0.03, off=1.0),
        Parameter("from_sample", (0.0, float(len(context))), float(len(context)), scanned=True),
    )


def _starts(context: Context, site: Site, around: Array | None) -> Iterable[Array]:
    if around is not None and around[1] == 0.0:
        return []
    rows = event_rows(context, None if around is None else float(around[1]))
    return [np.array([1.0, row]) for row in ([0.0, *rows] if around is None else rows)]


# --- how the simulated bench makes it ---


def inject(world: World, parameters: Mapping[str, Any], site: Site) -> World:
    """Move the lens so that the picture is `scale` times as large, from sample `from_sample` on (0: always)."""
    scale, start = float(parameters["scale"]), int(parameters["from_sample"])

    def focus(camera: Camera, moment: Moment) -> Camera:
        if moment.sample < start:
            return camera
        K = camera.K.copy()
        K[:2, :2] *= scale
        return replace(camera, K=K)

    return world.with_camera_motion(focus)


def _hide(rng: Generator, s: sealed.Situation) -> sealed.Hidden:
    """Draw how it is hidden in a sealed world."""
    sign, start = sealed.sign(rng), sealed.event(rng, s)  # off from the start it is a scale of the whole arm
    return sealed.Hidden(lambda a: {"scale": 1.0 + sign * a, "from_sample": start}, 0.005, 0.15)


def _left(assumed: Camera, true: Camera) -> dict[str, float]:
    return {"scale": float(true.K[0, 0] / assumed.K[0, 0])}


EFFECT = Effect(
    name="focal_length",
    summary="the focal length is off, or autofocus changed it",
    where="camera",
    stage=Stage.CAMERA,
    parameters=_parameters,
    term=term,
    starts=_starts,
    injector=inject,
    injected=(Injected("scale", (0.2, 5.0)), sample("from_sample", 0)),
    confused_with=("plane_offset", "camera_moved", "lens_distortion"),
    experiment="a gauge of known length laid in the arm's plane; the board photographed once more",
    needs_camera=True,
    left_by_calibration=_left,
    plans=("gauge_in_plane", "camera_elsewhere"),
    sealed=sealed.Sealing(_hide),
)
