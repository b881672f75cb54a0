"""Known sides of recordings for tests of effects: commands that go everywhere, an upright arm, the nominal camera."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from armtwin.models.arm import Arm, nominal_arm
from armtwin.models.camera import Camera
from armtwin.models.camera_files import nominal_camera
from armtwin.models.catalogue.context import Context, nominal_links
from armtwin.models.catalogue.points import Geometry
from armtwin.models.catalogue.predict import Active, camera_path, joint_angles, marker_points
from armtwin.models.catalogue.registry import Parameter, Site, effect_named
from armtwin.models.coordinate_frames import robot_to_board

Array = NDArray[np.float64]

BASE_MM = np.array([40.0, -33.0, -80.87])


def wandering_commands(n: int = 40, seed: int = 0) -> Array:
    """(n, 3) commands, rad, that reverse often and differ from pose to pose."""
    rng = np.random.default_rng(seed)
    return np.clip(np.cumsum(rng.uniform(-0.15, 0.15, (n, 3)), axis=0), -0.4, 0.4)


def context_of(q_cmd: Array | None = None, *, upright: bool = True, timed: bool = True, **changes: Any) -> Context:
    """Return the context of commands given to the paper's arm, all markers seen, one pose every two seconds."""
    q = wandering_commands() if q_cmd is None else np.asarray(q_cmd, dtype=float)
    arm, camera = _bench(upright)
    context = Context(
        arm=arm,
        camera=camera,
        plane_z_mm=float(BASE_MM[2]),
        markers=arm.marker_names,
        q_cmd=q,
        time_s=2.0 * np.arange(len(q)) if timed else None,
        trajectory=np.full(len(q), "path"),
        payload_kg=np.zeros(len(q)),
        temperature_c=None,
        links=nominal_links(arm),
    )
    return replace(context, **changes)


@lru_cache
def _bench(upright: bool) -> tuple[Arm, Camera]:
    arm = replace(nominal_arm(), gravity_m_s2=np.array([0.0, -9.81 if upright else 0.0]))
    return arm, nominal_camera()


def one_joint(joint: int, angles: Any) -> Array:
    """(N, 3) commands of joint `joint` (from 1) alone."""
    q = np.zeros((len(angles), 3))
    q[:, joint - 1] = angles
    return q


def drawn(context: Context) -> Geometry:
    """Return the drawing's chain at the assumed base."""
    return Geometry(np.zeros(2), context.links, complex(context.arm.link_lengths_mm[2]))


def pixels(context: Context, *effects: Active) -> Array:
    """(N, M, 2) pixels of the drawn arm with effects."""
    return predicted_pixels(context, drawn(context), effects, BASE_MM)


def predicted_pixels(context: Context, geometry: Geometry, effects: Sequence[Active], base_in_board_mm: Array) -> Array:
    """(N, M, 2) raw pixels of the context's markers."""
    assert context.camera is not None
    points = marker_points(context, geometry, joint_angles(context, effects), effects)
    return camera_path(context, effects).project(context.camera, robot_to_board(points, base_in_board_mm))


def active(name: str, values: Any, joint: int | None = None, marker: str | None = None) -> Active:
    """Return an effect of the catalogue with values of its first parameters; of the rest those of size are off."""
    effect, site = effect_named(name), Site(joint, marker)
    given = np.asarray(values, dtype=float)
    rest = [off_or(parameter, 0.5) for parameter in effect.parameters(context_of(), site)[len(given) :]]
    return Active(effect, site, np.array([*given, *rest]))


def off_or(parameter: Parameter, share: float) -> float:
    """Return the value at which a parameter is off; for one of shape, a value so far between its bounds."""
    low, high = parameter.bounds
    return low + share * (high - low) if parameter.off is None else float(np.clip(parameter.off, low, high))


def turned(name: str, context: Context, values: Any, joint: int | None = None) -> Array:
    """(N, n) what a term of commands, servos or joints makes of the commands."""
    return joint_angles(context, [active(name, values, joint)])
