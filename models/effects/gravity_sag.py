"""A joint gives under the torque of gravity.

The term is elasticity at each joint, solved at the sagged pose by two fixed-point steps: linear, or giving the less the
further it has given.

Known forms: linear springs (belts, printed horns), springs that stiffen, a servo's droop under load (its loop's
stiffness). Covered: give at each joint, linear or stiffening. Not covered: springs that soften, and give
that depends on the way the joint came (`hysteresis` or `backlash`).
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
# A spring that has given by one over the root of this is stiffer by a third or so; at a hundredth of a radian it stops.
_BOUNDS_PER_RAD2 = (0.0, 1e4)
# The power with which a spring stiffens whose torque grows with the cube of its angle.
_CUBIC = 1.0 / 3.0


def term(context: Context, q: Array, values: Array, site: Site) -> Array:
    """Angles that give by compliance times torque, `values` (n,) rad/(N m).

    Where (n,) more, 1/rad^2, a power and a switch follow, a joint gives the less the further: by b / (1 + s b^2)^p.
    A cubic spring has p of a third, a stop one of a half.
    """
    n = q.shape[1]
    compliance = values[:n]
    stiffens = values[n : 2 * n] if len(values) > n and values[-1] else np.zeros(n)
    power = float(values[2 * n]) if len(values) > n else 0.0
    give = _given(compliance * context.declared_torque(q), stiffens, power)
    out: Array = q + _given(compliance * context.declared_torque(q + give), stiffens, power)
    return out


def _given(linear: Array, stiffens: Array, power: float) -> Array:
    out: Array = linear / (1.0 + stiffens * linear**2) ** power
    return out


def told(context: Context, values: Array) -> list[int]:
    """Leave out how springs stiffen where they do not."""
    n = context.arm.n_joints
    return list(range(2 * n + 1)) if values[-1] else list(range(n))


def complexity(context: Context, values: Array) -> float:
    """Of each number that acts the logarithm of the rows."""
    n = context.arm.n_joints
    return (2 * n + 1 if values[-1] else n) * float(np.log(2 * len(context)))


def _parameters(context: Context, site: Site) -> tuple[Parameter, ...]:
    numbers = range(1, context.arm.n_joints + 1)
    return (
        *(Parameter(f"compliance{number}_rad_per_nm", _BOUNDS_RAD_PER_NM, 0.3) for number in numbers),
        *(Parameter(f"stiffens{number}_per_rad2", _BOUNDS_PER_RAD2, 500.0, off=None) for number in numbers),
        Parameter("stiffening_power", (0.1, 0.5), 0.2, off=None),
        Parameter("stiffening", (0.0, 1.0), 1.0, scanned=True),
    )


def _starts(context: Context, site: Site, around: Array | None) -> Iterable[Array]:
    if around is not None:
        return []
    n = context.arm.n_joints
    linear = [np.concatenate([np.full(n, 0.02), np.zeros(n), [_CUBIC, 0.0]])]
    return linear + [np.concatenate([np.full(n, 0.2), np.full(n, k), [_CUBIC, 1.0]]) for k in (25.0, 400.0)]


def physical(context: Context, values: Array) -> dict[str, Any]:
    """Return compliances, and where they stiffen how, as the simulated bench takes them."""
    n = context.arm.n_joints
    built = {f"compliance{joint + 1}_rad_per_nm": float(values[joint]) for joint in range(n)}
    if values[-1]:
        cubes = values[2 * n] * values[n : 2 * n]  # to third order the same
        built |= {f"stiffens{joint + 1}_per_rad2": float(cubes[joint]) for joint in range(n)}
    return built


def needs_gravity(context: Context, site: Site) -> str | None:
    """Say why an effect of weight cannot show in this recording, or None."""
    return None if context.has_gravity else "gravity has no part in the arm's plane"


# --- how the simulated bench makes it ---


def inject(world: World, parameters: Mapping[str, Any], site: Site) -> World:
    """Put a torsion spring between each servo and its link: gear teeth, horn and bracket that give.

    `compliance1_rad_per_nm`, `compliance2_rad_per_nm`, ...: one a joint; a joint without one is stiff. With
    `stiffensN_per_rad2` the spring's torque also grows with the cube of its angle.
    """
    numbers = range(1, world.arm.n_joints + 1)
    compliances = {n: float(parameters[f"compliance{n}_rad_per_nm"]) for n in numbers}
    cubes = {n: float(parameters.get(f"stiffens{n}_per_rad2", 0.0)) for n in numbers}

    def mechanism(spec: mujoco.MjSpec) -> None:
        for number, compliance in compliances.items():
            if compliance > 0:
                spring = add_spring(spec, number, f"sag{number}", compliance)
                spring.stiffness[2] = cubes[number] / compliance

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
    injected=(
        Injected("compliance{joint}_rad_per_nm", (0.0, 10.0), 0.0),
        Injected("stiffens{joint}_per_rad2", (0.0, 1e5), optional=True),
    ),
    confused_with=("payload", "link_bending", "servo_nonlinearity"),
    experiment="the arm turned against gravity, and a known mass at the tip",
    applies=needs_gravity,
    plans=("stretched_and_folded", "known_payload"),
    physical=physical,
    complexity=complexity,
    told=told,
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
    motions=("holds",),
    needs_load=True,
    injector=inject_in_motion,
    injected=(Injected("compliance_rad_per_nm", (0.0, 10.0)),),
)
