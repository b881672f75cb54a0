"""A joint axis that is not square to the plane.

What lies beyond the joint leaves the plane, towards the camera on one side and away from it on the other. The links
beyond may be square to their tilted axis, or square to the plane at zero angle.

Known forms: a bore drilled askew, a bracket that is bent or a printed joint that warped, all of them fixed; a bearing
with radial play, in which the axis wobbles. Covered: a fixed tilt about both directions, whichever side the links are
square to. Not covered: an axis that wobbles with the turn or under load (`unknown` where plain).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import mujoco
import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from armtwin.models.catalogue import sealed
from armtwin.models.catalogue.context import Context
from armtwin.models.catalogue.injection import Injected, switch
from armtwin.models.catalogue.points import PointState
from armtwin.models.catalogue.registry import Effect, Parameter, Site, Stage
from armtwin.models.world import World, joint_index

Array = NDArray[np.float64]


def term(context: Context, state: PointState, values: Array, site: Site) -> PointState:
    """Points beyond a joint whose axis is turned by (tilt_x, tilt_y) rad out of the normal, in the link before it."""
    assert site.joint is not None
    joint = site.joint - 1
    still = np.ones(len(context), dtype=complex)
    before = still if joint == 0 else state.frames(context)[:, joint - 1]
    lean = Rotation.from_rotvec([values[0], values[1], 0.0])
    if values[2]:
        # The joint's own angle: its zero, and those before it, are in how the links are built.
        turned = state.directions[:, joint] * np.conj(still if joint == 0 else state.directions[:, joint - 1])
        turn = np.angle(turned * np.exp(-1j * context.arm.zero_pose_rad[joint]))
        along_z = turn[:, None] * np.array([0.0, 0.0, 1.0])
        extra = lean * Rotation.from_rotvec(along_z) * lean.inv() * Rotation.from_rotvec(-along_z)
    else:
        extra = lean
    frame = Rotation.from_rotvec(np.angle(before)[:, None] * np.array([0.0, 0.0, 1.0]))
    extra = frame * extra * frame.inv()
    hinge = (state.geometry.links[:joint] * state.directions[:, :joint]).sum(axis=-1)
    pivot = np.stack([hinge.real, hinge.imag, np.zeros(len(hinge))], axis=-1)
    pivot[:, :2] += state.geometry.base_mm
    points = state.points_mm.copy()
    for column, name in enumerate(context.markers):
        if context.arm.links_to(name) > joint:
            points[:, column] = pivot + extra.apply(points[:, column] - pivot)
    return PointState(points, state.directions, state.geometry)


def _parameters(context: Context, site: Site) -> tuple[Parameter, ...]:
    return (
        Parameter("tilt_x_rad", (-0.3, 0.3), 0.03),
        Parameter("tilt_y_rad", (-0.3, 0.3), 0.03),
        Parameter("square_at_zero", (0.0, 1.0), 1.0, scanned=True),
    )


def _starts(context: Context, site: Site, around: Array | None) -> Iterable[Array]:
    return [] if around is not None else [np.array([0.0, 0.0, square]) for square in (0.0, 1.0)]


# --- how the simulated bench makes it ---


def inject(world: World, parameters: Mapping[str, Any], site: Site) -> World:
    """Mount the servo of `joint` askew: its axis is turned by `tilt_x_rad`, `tilt_y_rad` about axes of its mount.

    The mount is the base (the robot's axes) or the link before it (x along that link). With `square_at_zero` 1 (the
    default) the link lies in the plane at joint angle zero; with 0 it is square to its tilted axis.
    """
    number = joint_index(world, site) + 1
    square_at_zero = round(float(parameters["square_at_zero"])) == 1
    tilt = Rotation.from_rotvec([float(parameters["tilt_x_rad"]), float(parameters["tilt_y_rad"]), 0.0])

    def mechanism(spec: mujoco.MjSpec) -> None:
        body = spec.body(f"link{number}")
        if not square_at_zero:
            body.quat = (tilt * Rotation.from_quat(body.quat, scalar_first=True)).as_quat(scalar_first=True)
            return
        seat = Rotation.from_quat(body.quat, scalar_first=True)  # link axes in mount axes at joint angle zero
        for hinge in body.joints:
            hinge.axis = seat.apply(tilt.apply(seat.apply(hinge.axis)), inverse=True)

    return world.with_mechanism(mechanism)


def _hide(rng: Generator, s: sealed.Situation) -> sealed.Hidden:
    """Draw how it is hidden in a sealed world."""
    x, y = sealed.direction(rng, 2)
    square = int(rng.integers(0, 2))

    def parameters(a: float) -> dict[str, Any]:
        return {"tilt_x_rad": a * x, "tilt_y_rad": a * y, "square_at_zero": square}

    return sealed.Hidden(parameters, 0.02, 0.2, sealed.any_joint(rng, s))


EFFECT = Effect(
    name="axis_tilt",
    summary="a joint axis that is not square to the plane",
    where="joint",
    stage=Stage.POINTS,
    parameters=_parameters,
    term=term,
    starts=_starts,
    injector=inject,
    injected=(
        Injected("tilt_x_rad", (-1.0, 1.0)),
        Injected("tilt_y_rad", (-1.0, 1.0)),
        switch("square_at_zero", 1),
    ),
    confused_with=("camera_tilt", "lens_distortion"),
    experiment="the camera moved to another place; this joint turned alone over its whole range",
    needs_camera=True,
    plans=("camera_elsewhere", "full_sweep"),
    sealed=sealed.Sealing(_hide),
)
