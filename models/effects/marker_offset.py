"""A sticker off its joint's axis.

A sticker on an axis may be carried by the link before or after it; the offset turns with the link that carries it. An
offset of the tip's sticker is the same as another last link and belongs to the geometry.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from models.effects.context import Context
from models.effects.pixels import needs_camera
from models.effects.predict import PointState
from models.effects.registry import Effect, Parameter, Site, Stage

Array = NDArray[np.float64]


def term(context: Context, state: PointState, values: Array, site: Site) -> PointState:
    """Points with one sticker shifted by (x, y) mm in the frame of the link that carries it."""
    assert site.marker is not None
    x, y, body = values
    axis = context.arm.marker_names.index(site.marker)
    shift = np.full(len(context), complex(x, y))
    carrier = axis - 1 + round(float(body))
    if carrier >= 0:
        shift = shift * state.directions[:, carrier]
    points = state.points_mm.copy()
    column = context.markers.index(site.marker)
    points[:, column, 0] += shift.real
    points[:, column, 1] += shift.imag
    return PointState(points, state.directions, state.geometry)


def _parameters(context: Context, site: Site) -> tuple[Parameter, ...]:
    return (
        Parameter("x_mm", (-20.0, 20.0), 2.0),
        Parameter("y_mm", (-20.0, 20.0), 2.0),
        Parameter("body", (0.0, 1.0), 1.0, scanned=True),
    )


def _starts(context: Context, site: Site, around: Array | None) -> Iterable[Array]:
    return [] if around is not None else [np.array([0.0, 0.0, body]) for body in (0.0, 1.0)]


def _applies(context: Context, site: Site) -> str | None:
    if site.marker not in context.arm.marker_names[:-1]:
        return "an offset of a sticker on the last link is the last link itself"
    if len(context.markers) < 2:
        return "one marker alone cannot be off its axis"
    return needs_camera(context, site)


# --- how the simulated bench makes it ---


def inject(world: Any, parameters: Mapping[str, Any], joint: int | None = None, marker: str | None = None) -> Any:
    """To be written by the physics engineer."""
    raise NotImplementedError


EFFECT = Effect(
    name="marker_offset",
    summary="a sticker off its joint's axis",
    where="marker",
    stage=Stage.POINTS,
    parameters=_parameters,
    term=term,
    starts=_starts,
    inject=inject,
    confused_with=("axis_tilt", "lens_distortion"),
    experiment="each joint turned alone over its whole range",
    applies=_applies,
    plans=("full_sweep",),
)
