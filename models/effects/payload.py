"""An undeclared mass at the tip, for all of the recording or from some sample on.

It shows by the compliance of the joints, which is fitted along; only where declared weights load the same joints can
mass and compliance be told apart.

Known forms: a gripper or a cable that the drawing lacks, a tool taken up or put down, a cable that pulls more in some
poses. Covered: one point mass at the tip from one sample on. Not covered: a mass along a link, several changes, and a
cable's pull, whose direction is not that of gravity.
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
from armtwin.models.catalogue.injection import Injected, sample
from armtwin.models.catalogue.motion_effect import MotionEffect
from armtwin.models.catalogue.registry import Effect, Parameter, Site, Stage
from armtwin.models.catalogue.scan import event_rows, since
from armtwin.models.effects.gravity_sag import needs_gravity
from armtwin.models.mjcf import add_spring, add_tip_mass
from armtwin.models.motion_world import MotionWorld
from armtwin.models.world import Event, World

Array = NDArray[np.float64]


def term(context: Context, q: Array, values: Array, site: Site) -> Array:
    """Angles of compliant joints that carry `mass_kg` more at the tip from `from_sample` on."""
    mass, from_sample = values[0], values[1]
    compliance = values[2:]
    links, tip = context.masses_kg
    carried = tip + context.payload_kg + mass * since(context, from_sample)
    sagged = q + compliance * context.gravity_torque(q, links, carried)
    out: Array = q + compliance * context.gravity_torque(sagged, links, carried)
    return out


def _parameters(context: Context, site: Site) -> tuple[Parameter, ...]:
    return (
        Parameter("mass_kg", (0.0, 2.0), 0.2),
        Parameter("from_sample", (0.0, float(len(context))), float(len(context)), scanned=True),
        *(Parameter(f"compliance{joint + 1}_rad_per_nm", (0.0, 3.0), 0.3) for joint in range(context.arm.n_joints)),
    )


def _starts(context: Context, site: Site, around: Array | None) -> Iterable[Array]:
    n = context.arm.n_joints
    if around is not None and around[1] == 0.0:
        return []
    rows = event_rows(context, None if around is None else float(around[1]))
    if around is None:
        rows = [0.0, *rows]
    return [np.array([0.1, row, *np.full(n, 0.03)]) for row in rows]


# --- how the simulated bench makes it ---


def inject(world: World, parameters: Mapping[str, Any], site: Site) -> World:
    """Hang a point mass `mass_kg` at the tip just before sample `from_sample` (0: from the start).

    A stiff arm does not show it: the joints get springs of `compliance1_rad_per_nm`, ..., by default those of the
    servos' gears, which carry the arm's own weight too.
    """
    mass, start = float(parameters["mass_kg"]), int(parameters["from_sample"])
    gear = float(parameters.get("compliance_rad_per_nm", world.servo.gear_compliance_rad_nm))
    tip = f"end{world.arm.n_joints}"

    def mechanism(spec: mujoco.MjSpec) -> None:
        for number in range(1, world.arm.n_joints + 1):
            compliance = float(parameters.get(f"compliance{number}_rad_per_nm", gear))
            if compliance > 0:
                add_spring(spec, number, f"gear{number}", compliance)

    def hang(model: mujoco.MjModel, data: mujoco.MjData) -> None:
        add_tip_mass(model, int(model.body(tip).id), mass)

    return world.with_mechanism(mechanism).with_event(Event(start, hang))


def _hide(rng: Generator, s: sealed.Situation) -> sealed.Hidden:
    """Draw how it is hidden in a sealed world."""
    shares = rng.uniform(0.3, 1.0, s.arm.n_joints)
    mass = float(rng.uniform(0.05, 0.25))
    start = 0 if rng.random() < 0.3 else sealed.event(rng, s)

    def parameters(a: float) -> dict[str, Any]:
        springs = {f"compliance{j + 1}_rad_per_nm": a * v for j, v in enumerate(shares)}
        return {"mass_kg": mass, "from_sample": start, **springs}

    return sealed.Hidden(parameters, 0.05, 0.6)


EFFECT = Effect(
    name="payload",
    summary="an undeclared mass at the tip",
    where="arm",
    stage=Stage.JOINT,
    parameters=_parameters,
    term=term,
    starts=_starts,
    injector=inject,
    injected=(
        Injected("mass_kg", (0.0, 5.0)),
        sample("from_sample", 0),
        Injected("compliance_rad_per_nm", (0.0, 10.0), optional=True),
        Injected("compliance{joint}_rad_per_nm", (0.0, 10.0), optional=True),
    ),
    confused_with=("gravity_sag", "link_bending"),
    experiment="the same poses with and without a known mass at the tip",
    applies=needs_gravity,
    plans=("known_payload",),
    sealed=sealed.Sealing(_hide, in_gravity=True),
)


def inject_in_motion(world: MotionWorld, parameters: Mapping[str, Any], site: Site) -> MotionWorld:
    """Hang a point mass `mass_kg` at the tip at `from_s`, which the loops' integral parts do not carry.

    All joints give by `compliance_rad_per_nm` under it, by default by the compliance of the servo's gear.
    """
    gives = float(parameters.get("compliance_rad_per_nm", world.servo.gear_compliance_rad_nm))
    for index in range(world.arm.n_joints):
        world = world.with_drive(index, payload_compliance_rad_per_nm=gives)
    return replace(world, payload_kg=float(parameters["mass_kg"]), payload_from_s=float(parameters["from_s"]))


IN_MOTION = MotionEffect(
    name=EFFECT.name,
    summary=EFFECT.summary,
    where="arm",
    confused_with=("gravity_sag", "torque_limit"),
    experiment=EFFECT.experiment,
    motions=("holds",),
    needs_load=True,
    injector=inject_in_motion,
    injected=(
        Injected("mass_kg", (0.0, 5.0)),
        Injected("from_s", (-1e18, 1e18), -1e18),
        Injected("compliance_rad_per_nm", (0.0, 10.0), optional=True),
    ),
)
