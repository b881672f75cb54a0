"""Play at a joint: the link follows its horn only after the gap is taken up.

The term is the play operator: the output is dragged along by whichever edge of the gap touches it, and rests inside it
otherwise. Where gravity can shift the link inside its gap, the loaded edge carries it whatever side it came from.

Known forms: a gap in a gear train or a bore, between hard flanks (the play operator; M. Nordin and P.-O. Gutman,
Automatica 38, 2002); flanks that yield, so that the edges are soft; a dead band that stops at its edge, which moves the
same way.
Covered: hard edges, at rest or loaded to one side by gravity, a dead band's edge, and flanks that yield over a part of
the gap. Not covered: a gap that differs over the turn. The simulated bench has hard flanks alone.
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
    width, start_side, gravity_loaded, yielding, soft = values
    joint = _joint(site)
    out = q.copy()
    if gravity_loaded:
        out[:, joint] += 0.5 * width * np.sign(context.declared_torque(q)[:, joint])
    else:
        out[:, joint] = play(q[:, joint], width, start_side, yielding if soft else 0.0)
    return out


def play(drive: Array, width: float, start_side: float, yielding: float = 0.0) -> Array:
    """Return the output (N,) of a gap of `width` driven along (N,); it begins `start_side` half gaps off centre.

    Of each half gap the last part `yielding` is taken up by a flank that gives.
    """
    half = 0.5 * width
    if yielding * half > 0.0:
        return _soft_play(drive, half, start_side, yielding)
    out = []
    state = float(drive[0] + start_side * half)
    for angle in drive.tolist():
        if state < angle - half:
            state = angle - half
        elif state > angle + half:
            state = angle + half
        out.append(state)
    return np.array(out)


# How sharply a flank that gives ends: between a spring that is pressed flat at once (1) and a corner.
_SHARPNESS = 1.5


def _soft_play(drive: Array, half: float, start_side: float, yielding: float) -> Array:
    """Return the same for flanks that give: the further the drive is past their edge, the less they yield."""
    room = yielding * half
    edge = half - room
    out = []
    state = float(drive[0] + start_side * half)
    for angle in drive.tolist():
        ahead = angle - state
        pressed = abs(ahead) - edge
        if pressed > 0.0:
            left = pressed / (1.0 + (pressed / room) ** _SHARPNESS) ** (1.0 / _SHARPNESS)
            state += (pressed - left) if ahead > 0 else (left - pressed)
        out.append(state)
    return np.array(out)


def complexity(context: Context, values: Array) -> float:
    """Of width and yielding the logarithm of the rows, and twice that of the starts."""
    return (2.0 if values[4] else 1.0) * float(np.log(2 * len(context))) + 2.0 * float(np.log(_STARTS))


def told(context: Context, values: Array) -> list[int]:
    """Leave out how flanks yield where they do not."""
    return [0, 1, 2, 3] if values[4] else [0, 1, 2]


_STARTS = 10
# Where soft flanks are looked for from.
_YIELDING = 0.25


def _parameters(context: Context, site: Site) -> tuple[Parameter, ...]:
    return (
        Parameter("width_rad", (0.0, 0.35), 0.03),
        Parameter("start_side", (-1.0, 1.0), 1.0, scanned=True),
        Parameter("gravity_loaded", (0.0, 1.0), 1.0, scanned=True),
        Parameter("yielding", (0.02, 0.98), 0.3, off=None),
        Parameter("soft_edges", (0.0, 1.0), 1.0, scanned=True),
    )


def _starts(context: Context, site: Site, around: Array | None) -> Iterable[Array]:
    if around is not None:
        return []
    # The first move drags the link along its trailing edge, unless it began elsewhere in the gap.
    widths, sides = (0.003, 0.01, 0.03), (-1.0, 0.0, 1.0)
    starts = [np.array([width, side, 0.0, _YIELDING, 0.0]) for width in widths for side in sides]
    starts += [np.array([width, side, 0.0, _YIELDING, 1.0]) for width in widths[1:] for side in (-1.0, 1.0)]
    if context.has_gravity:
        starts.append(np.array([0.01, 0.0, 1.0, _YIELDING, 0.0]))
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
    complexity=complexity,
    told=told,
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
    motions=("reversals", "holds"),
    injector=inject_in_motion,
    injected=(Injected("width_rad", (0.0, 1.0)),),
)
