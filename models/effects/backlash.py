"""Play at a joint: the link follows its horn only after the gap is taken up.

The term is the play operator: the output is dragged along by whichever edge of the gap touches it, and rests inside it
otherwise. Where gravity can shift the link inside its gap, the loaded edge carries it whatever side it came from.

Known forms: a gap in a gear train or a bore, between hard flanks (the play operator; M. Nordin and P.-O. Gutman,
Automatica 38, 2002); flanks that yield, so that the edges are soft; a dead band that stops at its edge, which moves the
same way.
Covered: hard edges, at rest or loaded to one side by gravity, and a dead band's edge. Partly: soft edges are named so
as well, the softness as `hysteresis` of the same joint beside it where it shows, in some recordings as a false
`joint_slip`. Not covered: a gap that differs over the turn.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

import mujoco
import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from armtwin.models.catalogue import sealed
from armtwin.models.catalogue.context import Context
from armtwin.models.catalogue.injection import Injected, switch
from armtwin.models.catalogue.motion_effect import MotionEffect, Slot
from armtwin.models.catalogue.registry import Effect, Parameter, Site, Stage
from armtwin.models.mjcf import HINGE_INERTIA_KG_M2, SOLIMP, SOLREF, add_series_hinge, heaviest_torque_nm
from armtwin.models.motion_world import HARD_SOLIMP, HARD_SOLREF, MotionWorld
from armtwin.models.servo import gentle
from armtwin.models.world import World, joint_index

Array = NDArray[np.float64]


def term(context: Context, q: Array, values: Array, site: Site) -> Array:
    """Angles of the links behind a gap of `width_rad` at the site's joint."""
    width, start_side, gravity_loaded = values
    joint = _joint(site)
    out = q.copy()
    if gravity_loaded:
        out[:, joint] += 0.5 * width * np.sign(context.declared_torque(q)[:, joint])
    else:
        out[:, joint] = play(q[:, joint], width, start_side)
    return out


def play(drive: Array, width: float, start_side: float) -> Array:
    """Return the output (N,) of a gap of `width` driven along (N,); it begins `start_side` half gaps off centre."""
    half = 0.5 * width
    out = []
    state = float(drive[0] + start_side * half)
    for angle in drive.tolist():
        if state < angle - half:
            state = angle - half
        elif state > angle + half:
            state = angle + half
        out.append(state)
    return np.array(out)


def _parameters(context: Context, site: Site) -> tuple[Parameter, ...]:
    return (
        Parameter("width_rad", (0.0, 0.35), 0.03),
        Parameter("start_side", (-1.0, 1.0), 1.0, scanned=True),
        Parameter("gravity_loaded", (0.0, 1.0), 1.0, scanned=True),
    )


def _starts(context: Context, site: Site, around: Array | None) -> Iterable[Array]:
    if around is not None:
        return []
    # The first move drags the link along its trailing edge, unless it began elsewhere in the gap.
    starts = [np.array([width, side, 0.0]) for width in (0.003, 0.01, 0.03) for side in (-1.0, 0.0, 1.0)]
    if context.has_gravity:
        starts.append(np.array([0.01, 0.0, 1.0]))
    return starts


def _joint(site: Site) -> int:
    assert site.joint is not None
    return site.joint - 1


# --- how the simulated bench makes it ---


# A tight printed bearing: what it holds beyond the arm's own weight.
_BEARING_RESERVE = 1.5
_BEARING_FRICTION_NM = 0.1
# Grease in the bearing: a link does not coast through the gap, and one that falls through it does not bounce.
_GREASE_NMS_RAD = 0.2


def inject(world: World, parameters: Mapping[str, Any], site: Site) -> World:
    """Put a hinge that turns freely between two stops behind the servo of `joint`.

    `width_rad` is the whole gap. The link's bearing drags on the frame with `friction_nm`, by default more than the
    arm's weight, so that the link stays where it was pushed. With less (`gravity_loaded` 1: none), gravity lays it
    against the loaded side.
    """
    number = joint_index(world, site) + 1
    width = float(parameters["width_rad"])
    if width == 0.0:  # no gap
        return world
    holding = _BEARING_FRICTION_NM + _BEARING_RESERVE * heaviest_torque_nm(world.arm, number)
    loose = bool(parameters["gravity_loaded"])
    friction = float(parameters.get("friction_nm", 0.0 if loose else holding))

    def mechanism(spec: mujoco.MjSpec) -> None:
        gap = add_series_hinge(spec, number, f"gap{number}")
        gap.limited = True
        gap.range = [-width / 2, width / 2]
        bearing = spec.add_tendon(name=f"bearing{number}")  # its length is the link's angle against the frame
        bearing.wrap_joint(f"joint{number}", 1.0)
        bearing.wrap_joint(f"gap{number}", 1.0)
        bearing.frictionloss = friction
        bearing.damping[0] = _GREASE_NMS_RAD
        bearing.solref_friction = SOLREF
        bearing.solimp_friction = SOLIMP

    return replace(world, servo=gentle(world.servo)).with_mechanism(mechanism)


def _hide(rng: Generator, s: sealed.Situation) -> sealed.Hidden:
    """Draw how it is hidden in a sealed world."""
    return sealed.Hidden(lambda a: {"width_rad": a}, 0.01, 0.15, sealed.any_joint(rng, s))


EFFECT = Effect(
    name="backlash",
    summary="play at a joint: the link follows only after the gap is taken up",
    where="joint",
    stage=Stage.JOINT,
    parameters=_parameters,
    term=term,
    starts=_starts,
    injector=inject,
    injected=(
        Injected("width_rad", (0.0, 1.0)),
        switch("gravity_loaded", 0),
        Injected("friction_nm", (0.0, 10.0), optional=True),
    ),
    confused_with=("hysteresis", "dead_band", "settling_lag"),
    experiment="fine steps of this joint round a reversal, approached from both sides",
    plans=("reversal",),
    needs_return=True,
    sealed=sealed.Sealing(_hide),
)

# What holds and brakes a link in its gap, over the stiffness of the drive's loop, which they lead astray by as much.
_HELD_SHARE_RAD = 2e-5
_GREASE_SHARE_S = 1e-4
# The longest step of the simulation of a moving arm.
_STEP_S = 0.001


def inject_in_motion(world: MotionWorld, parameters: Mapping[str, Any], site: Site) -> MotionWorld:
    """Put a hinge that turns freely between two stops behind the drive of `joint`, and the encoder behind it.

    Gravity is balanced, and the link's bearing holds it where it was pushed.
    """
    (index,) = world.joints_at(site)
    width, joint = float(parameters["width_rad"]), world.arm.joints[index]
    if width == 0.0:  # no gap
        return world

    def mechanism(spec: mujoco.MjSpec, scale: float) -> None:
        drive = spec.joint(joint)
        gap = drive.parent.add_joint(name=f"gap_{joint}", axis=drive.axis, pos=drive.pos, armature=HINGE_INERTIA_KG_M2)
        gap.limited = int(mujoco.mjtLimited.mjLIMITED_TRUE)
        gap.range = [-width / 2, width / 2]
        gap.solref_limit, gap.solimp_limit = HARD_SOLREF, HARD_SOLIMP
        bearing = spec.add_tendon(name=f"bearing_{joint}")  # its length is the link's angle against the frame
        bearing.wrap_joint(joint, 1.0)
        bearing.wrap_joint(f"gap_{joint}", 1.0)
        bearing.frictionloss = _HELD_SHARE_RAD * scale
        bearing.damping[0] = _GREASE_SHARE_S * scale
        bearing.armature = _GREASE_SHARE_S * scale * _STEP_S  # so that grease works within a step
        bearing.solref_friction, bearing.solimp_friction = HARD_SOLREF, HARD_SOLIMP

    return world.with_mechanism(mechanism).with_series_hinge(index, f"gap_{joint}")


IN_MOTION = MotionEffect(
    name=EFFECT.name,
    summary=EFFECT.summary,
    where="joint",
    forms=((Slot("width_rad", "play_rad", (0.0, 0.35), (0.003, 0.01, 0.03), 0.001),),),
    confused_with=("hysteresis", "friction", "dead_band"),
    experiment="slow reversals under load and without: play stays as wide, the band of friction follows the load",
    injector=inject_in_motion,
    injected=(Injected("width_rad", (0.0, 1.0)),),
)
