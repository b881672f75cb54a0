"""The arm's plane is not at the assumed distance.

Seen from one camera this scales the whole plane about the foot of the camera, as longer links and a moved base do: no
data of one plane can tell. It is therefore part of the gauge of the geometry and never named as a cause.

Known forms: a spacer or a board's thickness that was forgotten, stickers on the links' faces instead of in their
middle. None can be told here; a picture of the board in the arm's plane, or a second camera, tells it.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from armtwin.models.catalogue import sealed
from armtwin.models.catalogue.camera_path import CameraPath
from armtwin.models.catalogue.context import Context
from armtwin.models.catalogue.injection import Injected
from armtwin.models.catalogue.registry import Effect, Parameter, Site, Stage
from armtwin.models.world import World

Array = NDArray[np.float64]


def term(context: Context, path: CameraPath, values: Array, site: Site) -> CameraPath:
    """Camera that sees the plane `offset_mm` farther along the board's z axis."""
    assert context.camera is not None
    return path.turned(np.zeros((1, 3)), values[0] * context.camera.R_board_camera[:, 2][None, :])


def _parameters(context: Context, site: Site) -> tuple[Parameter, ...]:
    return (Parameter("offset_mm", (-100.0, 100.0), 10.0),)


def _starts(context: Context, site: Site, around: Array | None) -> Iterable[Array]:
    return [] if around is not None else [np.zeros(1)]


# --- how the simulated bench makes it ---


def inject(world: World, parameters: Mapping[str, Any], site: Site) -> World:
    """Stand the arm `offset_mm` further from the camera (along z of the board) than was measured."""
    offset = np.array([0.0, 0.0, float(parameters["offset_mm"])])
    return replace(world, base_in_board_mm=world.base_in_board_mm + offset)


def _hide(rng: Generator, s: sealed.Situation) -> sealed.Hidden:
    """Draw how it is hidden in a sealed world."""
    sign = sealed.sign(rng)
    return sealed.Hidden(lambda a: {"offset_mm": sign * a}, 5.0, 40.0)


EFFECT = Effect(
    name="plane_offset",
    summary="the arm's plane is not at the assumed distance",
    where="camera",
    stage=Stage.CAMERA,
    parameters=_parameters,
    term=term,
    starts=_starts,
    injector=inject,
    injected=(Injected("offset_mm", (-400.0, 1000.0)),),
    confused_with=("focal_length",),
    experiment="a gauge of known length laid in the arm's plane, or one link measured with a calliper",
    gauge="a plane nearer or farther than assumed scales all link lengths and the base together; a gauge of known "
    "length in the arm's plane, or one link measured with a calliper, breaks the tie",
    plans=("gauge_in_plane",),
    sealed=sealed.Sealing(_hide),
)
