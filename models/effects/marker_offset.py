"""A sticker off its joint's axis.

A sticker on an axis may be carried by the link before or after it; the offset turns with the link that carries it. An
offset of the tip's sticker is the same as another last link and belongs to the geometry.

Known forms: a sticker put on beside the axis, a round one cut off its centre, a screw's head that stands in for the
axis. Covered: a fixed offset, carried by the link before or after. Not covered: a sticker that slides or peels, and
the eccentric picture of a large circle seen askew (J. Heikkila, IEEE PAMI 22, 2000).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import mujoco
import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from armtwin.models.catalogue import sealed
from armtwin.models.catalogue.context import Context
from armtwin.models.catalogue.injection import Injected, switch
from armtwin.models.catalogue.points import PointState
from armtwin.models.catalogue.registry import Effect, Parameter, Site, Stage
from armtwin.models.mjcf import ride_on_link
from armtwin.models.units import M_PER_MM
from armtwin.models.world import World, checked_marker

Array = NDArray[np.float64]


def term(context: Context, state: PointState, values: Array, site: Site) -> PointState:
    """Points with one sticker shifted by (x, y) mm in the frame of the link that carries it."""
    assert site.marker is not None
    x, y, body = values
    axis = context.arm.marker_names.index(site.marker)
    shift = np.full(len(context), complex(x, y))
    carrier = axis - 1 + round(float(body))
    if carrier >= 0:
        shift = shift * state.frames(context)[:, carrier]
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
    return None


# --- how the simulated bench makes it ---


def inject(world: World, parameters: Mapping[str, Any], site: Site) -> World:
    """Stick `marker` `x_mm`, `y_mm` off its place, in the axes of the body that carries it.

    With `body` 0 (the default) that is the link before its axis (the base for the first marker, with the robot's
    axes), with `body` 1 the link after it; x runs along the link.
    """
    name = checked_marker(world, site.marker)
    offset = np.array([float(parameters["x_mm"]), float(parameters["y_mm"]), 0.0]) * M_PER_MM
    on_next_link = round(float(parameters["body"])) == 1 and name in world.arm.marker_names[:-1]

    def mechanism(spec: mujoco.MjSpec) -> None:
        for part in (spec.site(f"marker_{name}"), spec.geom(f"sticker_{name}")):
            part.pos = np.array(part.pos) + offset
        if on_next_link:
            ride_on_link(spec, name, world.arm.marker_names.index(name) + 1)

    return world.with_mechanism(mechanism)


def _hide(rng: Generator, s: sealed.Situation) -> sealed.Hidden:
    """Draw how it is hidden in a sealed world."""
    name = str(rng.choice([m for m in s.markers if m in s.arm.marker_names[:-1]]))
    x, y = sealed.direction(rng, 2)
    body = int(rng.integers(0, 2))
    return sealed.Hidden(lambda a: {"x_mm": a * x, "y_mm": a * y, "body": body}, 1.0, 15.0, Site(marker=name))


EFFECT = Effect(
    name="marker_offset",
    summary="a sticker off its joint's axis",
    where="marker",
    stage=Stage.POINTS,
    parameters=_parameters,
    term=term,
    starts=_starts,
    injector=inject,
    injected=(Injected("x_mm", (-100.0, 100.0)), Injected("y_mm", (-100.0, 100.0)), switch("body", 0)),
    confused_with=("axis_tilt", "lens_distortion"),
    experiment="each joint turned alone over its whole range",
    applies=_applies,
    needs_camera=True,
    plans=("full_sweep",),
    sealed=sealed.Sealing(_hide, all_markers=True),
)
