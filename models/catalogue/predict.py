"""The extended twin: predicted angles, points and pixels of an arm with any set of effects."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armtwin.models.catalogue.camera_path import CameraPath
from armtwin.models.catalogue.context import Context
from armtwin.models.catalogue.effect import Effect
from armtwin.models.catalogue.points import Geometry, PointState
from armtwin.models.catalogue.site import Site

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True, eq=False)
class Active:
    """An effect at a site with values of its parameters, (k,)."""

    effect: Effect
    site: Site
    values: Array

    @property
    def key(self) -> tuple[str, int | None, str | None]:
        """Its name, joint and marker."""
        return (self.effect.name, self.site.joint, self.site.marker)

    @property
    def label(self) -> str:
        """Its name and site for people."""
        return f"{self.effect.name} ({'camera' if self.effect.where == 'camera' else self.site})"


def ordered(effects: Sequence[Active]) -> list[Active]:
    """Sort effects in the order in which they act."""
    return sorted(effects, key=lambda active: active.effect.stage)


def joint_angles(context: Context, effects: Sequence[Active]) -> Array:
    """(N, n) angles at which the links stand when the rows are seen, rad.

    The terms step through the commands in the order in which they were given, what remembers among them.
    """
    q = context.commands.q
    for active in ordered(effects):
        if (term := active.effect.angle_term) is not None:
            q = term(context, q, active.values, active.site)
    return context.commands.sampled(q)


def marker_points(context: Context, geometry: Geometry, q: Array, effects: Sequence[Active] = ()) -> Array:
    """(N, M, 3) markers in the robot frame, mm, for (N, n) link angles."""
    directions = context.directions(q)
    chain = np.concatenate(
        [np.zeros((len(q), 1), dtype=complex), np.cumsum(geometry.links * directions, axis=-1)], axis=-1
    )
    columns = []
    for name in context.markers:
        reach = context.arm.links_to(name)
        if context.arm.is_corner(name):
            columns.append(chain[:, reach - 1] + geometry.corner * directions[:, reach - 1])
        else:
            columns.append(chain[:, reach])
    z = np.stack(columns, axis=-1)
    points = np.zeros((*z.shape, 3))
    points[..., 0] = z.real + geometry.base_mm[0]
    points[..., 1] = z.imag + geometry.base_mm[1]
    state = PointState(points, directions, geometry)
    for active in ordered(effects):
        if (term := active.effect.point_term) is not None:
            state = term(context, state, active.values, active.site)
    return state.points_mm


def camera_path(context: Context, effects: Sequence[Active]) -> CameraPath:
    """Return the camera's departures from its assumed pose and lens."""
    path = CameraPath.as_assumed()
    for active in ordered(effects):
        if (term := active.effect.camera_term) is not None:
            path = term(context, path, active.values, active.site)
    return path
