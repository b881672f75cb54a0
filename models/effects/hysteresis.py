"""Friction-held lag that grows smoothly after a reversal.

The term is Dahl's model of friction without velocity (P. Dahl, "A solid friction model", 1968): after a reversal the
lag approaches its saturated value exponentially over the travelled angle.

Known forms: bristles or asperities that yield one after another (Maxwell slip), a lag that grows exponentially after a
reversal (Dahl), both with the same saturated lag. Covered: those two. Not covered: a lag that depends on speed or load,
or that relaxes while the arm rests (`unknown` where plain).
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
from armtwin.models.catalogue.injection import Injected
from armtwin.models.catalogue.motion_effect import MotionEffect, Slot
from armtwin.models.catalogue.registry import Effect, Parameter, Site, Stage
from armtwin.models.errors import InputError
from armtwin.models.mjcf import SPRING_TIME_S, add_series_hinge
from armtwin.models.motion_world import MotionWorld
from armtwin.models.servo import gentle
from armtwin.models.world import World, joint_index

Array = NDArray[np.float64]


def term(context: Context, q: Array, values: Array, site: Site) -> Array:
    """Angles that lag behind the drive by up to `lag_rad`, built up over `length_rad` of travel."""
    lag, length, start_side = values
    assert site.joint is not None
    joint = site.joint - 1
    out = q.copy()
    state = start_side * lag
    drive = q[:, joint]
    moves = np.diff(drive, prepend=drive[0]).tolist()
    held = np.empty(len(q))
    for row, move in enumerate(moves):
        if move:
            goal = lag if move > 0 else -lag
            state = goal + (state - goal) * float(np.exp(-abs(move) / length))
        held[row] = state
    out[:, joint] -= held
    return out


def physical(context: Context, values: Array) -> dict[str, Any]:
    """Return lag and length as the simulated bench takes them: no bristles build a lag up on less travel."""
    lag, length, _ = values.tolist()
    return {"lag_rad": lag, "length_rad": max(length, _LEAST_LENGTH * lag)}


def _parameters(context: Context, site: Site) -> tuple[Parameter, ...]:
    return (
        Parameter("lag_rad", (0.0, 0.2), 0.02),
        Parameter("length_rad", (1e-4, 1.0), 0.1, off=None),
        Parameter("start_side", (-1.0, 1.0), 1.0, scanned=True),
    )


def _starts(context: Context, site: Site, around: Array | None) -> Iterable[Array]:
    if around is not None:
        return []
    return [np.array([0.005, length, side]) for length in (0.01, 0.03, 0.08, 0.2) for side in (-1.0, 0.0, 1.0)]


# --- how the simulated bench makes it ---


# Friction of the bearing when all of its bristles slide; only its ratio to the drive's stiffness shows.
_SLIDING_FRICTION_NM = 0.2
# Travel over lag below which the link would have to jump, rounded up.
_LEAST_LENGTH = 2.5
# Share of the sliding friction that holds when the bristles yield one after another.
_BRISTLE_SHARES = np.array([0.25, 0.5, 0.7, 0.85, 0.95, 1.0])


def inject(world: World, parameters: Mapping[str, Any], site: Site) -> World:
    """Drive link `joint` through a spring against a bearing whose bristles stick and yield one after another.

    Maxwell-slip friction: springs in parallel, each with a yield point. When all of them slide the link lags by
    `lag_rad`; after a reversal the lag has changed by 1 - 1/e of its swing once `length_rad` was commanded. The arm's
    own weight is balanced at the spring: only friction bends it. Raises `InputError` where the length is too short
    for the lag (the link would have to jump).
    """
    number = joint_index(world, site) + 1
    lag, length = float(parameters["lag_rad"]), float(parameters["length_rad"])
    if lag == 0.0:  # no friction
        return world
    drive = _SLIDING_FRICTION_NM / lag
    stiffness, travel = _physical_bristles(lag, length)

    def mechanism(spec: mujoco.MjSpec) -> None:
        hinge = add_series_hinge(spec, number, f"lag{number}")
        hinge.stiffness[0] = drive
        hinge.damping[0] = SPRING_TIME_S * drive
        for k, (spring, give) in enumerate(zip(stiffness, travel, strict=True)):
            bristle = spec.add_tendon(name=f"bristle{number}_{k}")  # its length is the link's angle against the frame
            bristle.wrap_joint(f"joint{number}", 1.0)
            bristle.wrap_joint(f"lag{number}", 1.0)
            bristle.stiffness[0] = spring
            bristle.springlength = [0.0, 0.0]
            bristle.springyield = give

    return replace(world, servo=gentle(world.servo)).with_mechanism(mechanism, relieved=(f"lag{number}",))


def _physical_bristles(lag: float, length: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Stiffness, N m/rad, and yield, rad, of each bristle so that friction grows as wanted over the link's travel.

    First loading follows 1 - exp(-2 u / length) of the command u (by Masing's rule a reversal then takes twice that
    travel), up to 95 % of it, where it closes; the link travels u less its lag.
    """
    share = np.concatenate([[0.0], _BRISTLE_SHARES])
    commanded = -length / 2 * np.log1p(-np.minimum(share, 0.98))
    travel = commanded - lag * share
    if np.any(np.diff(travel) <= 0):
        raise InputError(
            f"hysteresis: length_rad {length:g} is too short for lag_rad {lag:g}; at least {_LEAST_LENGTH} times it"
        )
    slope = np.append(_SLIDING_FRICTION_NM * np.diff(share) / np.diff(travel), 0.0)
    return slope[:-1] - slope[1:], travel[1:]


def _hide(rng: Generator, s: sealed.Situation) -> sealed.Hidden:
    """Draw how it is hidden in a sealed world."""
    ratio = rng.uniform(3.0, 8.0)  # build-up in lags; below about 2.5 the link would have to jump
    return sealed.Hidden(lambda a: {"lag_rad": a, "length_rad": ratio * a}, 0.005, 0.06, sealed.any_joint(rng, s))


EFFECT = Effect(
    name="hysteresis",
    summary="friction-held lag that grows smoothly after a reversal",
    where="joint",
    stage=Stage.JOINT,
    parameters=_parameters,
    term=term,
    starts=_starts,
    injector=inject,
    injected=(Injected("lag_rad", (0.0, 0.5)), Injected("length_rad", (1e-4, 3.0))),
    confused_with=("backlash", "settling_lag"),
    experiment="fine steps of this joint round a reversal: play keeps still, then follows one to one; friction bends",
    plans=("reversal",),
    physical=physical,
    needs_return=True,
    sealed=sealed.Sealing(_hide),
)


def inject_in_motion(world: MotionWorld, parameters: Mapping[str, Any], site: Site) -> MotionWorld:
    """Let the drive of `joint` rub on bristles that stick and yield one after another, as in `inject`.

    When all of them slide, the loop is led astray by `lag_rad`.
    """
    (index,) = world.joints_at(site)
    lag, length, joint = float(parameters["lag_rad"]), float(parameters["length_rad"]), world.arm.joints[index]
    if lag == 0.0:  # no friction
        return world
    stiffness, travel = _physical_bristles(lag, length)

    def mechanism(spec: mujoco.MjSpec, scale: float) -> None:
        for k, (spring, give) in enumerate(zip(stiffness, travel, strict=True)):
            bristle = spec.add_tendon(name=f"bristle_{joint}_{k}")
            bristle.wrap_joint(joint, 1.0)
            bristle.stiffness[0] = spring * scale * lag / _SLIDING_FRICTION_NM
            bristle.springlength = [0.0, 0.0]
            bristle.springyield = give

    reserve = world.drives[index].reserve_rad + lag
    return world.with_drive(index, reserve_rad=reserve).with_mechanism(mechanism)


IN_MOTION = MotionEffect(
    name=EFFECT.name,
    summary=EFFECT.summary,
    where="joint",
    forms=(
        (
            Slot("lag_rad", "lag_rad", (0.0, 0.2), (0.003, 0.01), 0.001),
            Slot("length_rad", "lag_angle_rad", (0.002, 1.0), (0.03, 0.15), 0.01),
        ),
    ),
    confused_with=("backlash", "friction"),
    experiment=EFFECT.experiment,
    motions=("reversals",),
    injector=inject_in_motion,
    injected=(Injected("lag_rad", (0.0, 0.5)), Injected("length_rad", (1e-4, 3.0))),
)
