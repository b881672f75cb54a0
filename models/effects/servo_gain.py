"""The servo turns a wrong fraction of what is commanded.

Known forms: a pulse scale that is not the servo's (microseconds a degree), a potentiometer's track of another span, a
belt or gear ratio that is not the drawing's. Covered: all, as one factor from the joint's zero on; about another centre
the difference is the joint's zero. A scale that is bent as well is told as `servo_nonlinearity` alone.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from armtwin.models.catalogue import sealed
from armtwin.models.catalogue.context import Context
from armtwin.models.catalogue.injection import Injected
from armtwin.models.catalogue.motion_effect import MotionEffect, Slot
from armtwin.models.catalogue.registry import Effect, Parameter, Site, Stage
from armtwin.models.motion_world import MotionWorld
from armtwin.models.world import Command, Electronics, World, joint_index

Array = NDArray[np.float64]


def term(context: Context, q: Array, values: Array, site: Site) -> Array:
    """Angles of a servo that turns `gain` times its command."""
    assert site.joint is not None
    out = q.copy()
    out[:, site.joint - 1] *= values[0]
    return out


def _parameters(context: Context, site: Site) -> tuple[Parameter, ...]:
    return (Parameter("gain", (0.5, 1.5), 0.05, off=1.0),)


def _starts(context: Context, site: Site, around: Array | None) -> Iterable[Array]:
    return [] if around is not None else [np.array([1.0])]


# --- how the simulated bench makes it ---


def inject(world: World, parameters: Mapping[str, Any], site: Site) -> World:
    """Give the servo of `joint` a potentiometer whose track spans another angle than its scale says.

    The board turns until the wiper's voltage matches the pulse; `gain` is the track's true span over the nominal one.
    """
    index = joint_index(world, site)
    track_rad = world.servo.travel_rad * float(parameters["gain"])

    def board() -> Electronics:
        def receive(command: Command) -> NDArray[np.float64]:
            voltage = command.q[index] / world.servo.travel_rad
            q = command.q.copy()
            q[index] = voltage * track_rad
            return q

        return receive

    return world.with_electronics(board)


def _hide(rng: Generator, s: sealed.Situation) -> sealed.Hidden:
    """Draw how it is hidden in a sealed world."""
    sign = sealed.sign(rng)
    return sealed.Hidden(lambda a: {"gain": 1.0 + sign * a}, 0.03, 0.3, sealed.any_joint(rng, s))


EFFECT = Effect(
    name="servo_gain",
    summary="the servo turns a wrong fraction of what is commanded",
    where="joint",
    stage=Stage.SERVO,
    parameters=_parameters,
    term=term,
    starts=_starts,
    injector=inject,
    injected=(Injected("gain", (0.1, 3.0)),),
    confused_with=("servo_nonlinearity",),
    experiment="this joint swept over its whole range",
    plans=("full_sweep",),
    as_gear="gain",
    sealed=sealed.Sealing(_hide),
)


def inject_in_motion(world: MotionWorld, parameters: Mapping[str, Any], site: Site) -> MotionWorld:
    """Give the drive of `joint` a potentiometer whose track spans another angle than its scale says, as `inject`."""
    (index,) = world.joints_at(site)
    track_rad = world.servo.travel_rad * float(parameters["gain"])
    return world.with_values(index, lambda q: q / world.servo.travel_rad * track_rad)


IN_MOTION = MotionEffect(
    name=EFFECT.name,
    summary=EFFECT.summary,
    where="joint",
    forms=((Slot("gain", "gain", (0.3, 2.0), (1.0,), 0.005),),),
    confused_with=EFFECT.confused_with,
    experiment=EFFECT.experiment,
    motions=("holds",),
    injector=inject_in_motion,
    injected=(Injected("gain", (0.1, 3.0)),),
)
