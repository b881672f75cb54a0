"""A joint gives under the torque of gravity.

The term is linear elasticity at each joint, solved at the sagged pose by two fixed-point steps.

Known forms: linear springs (belts, printed horns), springs that stiffen, a servo's droop under load (its loop's
stiffness). Covered: linear give at each joint. Partly: a spring that stiffens by some tenths over the arm's range is
named so too, in some recordings with a false `servo_nonlinearity` beside it. Not covered: give that depends on the way
the joint came (`hysteresis` or `backlash`).
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
from armtwin.models.catalogue.injection import Injected
from armtwin.models.catalogue.motion_effect import MotionEffect, Slot
from armtwin.models.catalogue.registry import Effect, Parameter, Site, Stage
from armtwin.models.mjcf import add_spring
from armtwin.models.motion_world import MotionWorld
from armtwin.models.world import World

Array = NDArray[np.float64]


_BOUNDS_RAD_PER_NM = (0.0, 3.0)


def term(context: Context, q: Array, values: Array, site: Site) -> Array:
    """Angles that give by compliance times torque, `values` (n,) rad/(N m)."""
    sagged = q + values * context.declared_torque(q)
    out: Array = q + values * context.declared_torque(sagged)
    return out


def _parameters(context: Context, site: Site) -> tuple[Parameter, ...]:
    return tuple(
        Parameter(f"compliance{joint + 1}_rad_per_nm", _BOUNDS_RAD_PER_NM, 0.3) for joint in range(context.arm.n_joints)
    )


def _starts(context: Context, site: Site, around: Array | None) -> Iterable[Array]:
    return [] if around is not None else [np.full(context.arm.n_joints, 0.02)]


def needs_gravity(context: Context, site: Site) -> str | None:
    """Say why an effect of weight cannot show in this recording, or None."""
    return None if context.has_gravity else "gravity has no part in the arm's plane"


# --- how the simulated bench makes it ---


def inject(world: World, parameters: Mapping[str, Any], site: Site) -> World:
    """Put a torsion spring between each servo and its link: gear teeth, horn and bracket that give.

    `compliance1_rad_per_nm`, `compliance2_rad_per_nm`, ...: one a joint; a joint without one is stiff.
    """
    numbers = range(1, world.arm.n_joints + 1)
    compliances = {n: float(parameters[f"compliance{n}_rad_per_nm"]) for n in numbers}

    def mechanism(spec: mujoco.MjSpec) -> None:
        for number, compliance in compliances.items():
            if compliance > 0:
                add_spring(spec, number, f"sag{number}", compliance)

    return world.with_mechanism(mechanism)


def _hide(rng: Generator, s: sealed.Situation) -> sealed.Hidden:
    """Draw how it is hidden in a sealed world."""
    shares = rng.uniform(0.3, 1.0, s.arm.n_joints)
    return sealed.Hidden(lambda a: {f"compliance{j + 1}_rad_per_nm": a * v for j, v in enumerate(shares)}, 0.05, 1.0)


EFFECT = Effect(
    name="gravity_sag",
    summary="a joint gives under the torque of gravity",
    where="arm",
    stage=Stage.JOINT,
    parameters=_parameters,
    term=term,
    starts=_starts,
    injector=inject,
    injected=(Injected("compliance{joint}_rad_per_nm", (0.0, 10.0), 0.0),),
    confused_with=("payload", "link_bending", "servo_nonlinearity"),
    experiment="the arm turned against gravity, and a known mass at the tip",
    applies=needs_gravity,
    plans=("stretched_and_folded", "known_payload"),
    sealed=sealed.Sealing(_hide, in_gravity=True),
)


def inject_in_motion(world: MotionWorld, parameters: Mapping[str, Any], site: Site) -> MotionWorld:
    """Take the integral part out of the loop: it gives under the torque of gravity."""
    (index,) = world.joints_at(site)
    gives = world.drives[index].compliance_rad_per_nm + float(parameters["compliance_rad_per_nm"])
    return world.with_drive(index, compliance_rad_per_nm=gives)


IN_MOTION = MotionEffect(
    name=EFFECT.name,
    summary=EFFECT.summary,
    where="joint",
    forms=((Slot("compliance_rad_per_nm", "droop_rad_nm", (0.0, 5.0), (0.02, 0.1), 0.005),),),
    confused_with=("payload", "friction", "servo_nonlinearity"),
    experiment="holds with the arm stretched and folded, and with a known mass at the tip",
    needs_load=True,
    injector=inject_in_motion,
    injected=(Injected("compliance_rad_per_nm", (0.0, 10.0)),),
)
