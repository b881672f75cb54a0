"""The picture was taken before the arm arrived.

The term is a first-order approach: of every step a fraction remains when the picture is taken, after the usual (median)
wait, and the arm goes on until the next command. Where no times of commands were recorded, a bench may have waited
equally long before every picture, or taken it when the next command was due.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from armtwin.models.catalogue.context import Context
from armtwin.models.catalogue.injection import Injected
from armtwin.models.catalogue.registry import Effect, Parameter, Site, Stage
from armtwin.models.world import World

Array = NDArray[np.float64]


def term(context: Context, q: Array, values: Array, site: Site) -> Array:
    """Angles that lack the fraction `values[:n]` of each step."""
    remaining = np.clip(values[:-1], -0.95, 0.99)
    timed = values[-1] or context.commanded_s is not None
    waits, spans = (context.relative_waits, context.relative_spans) if timed else (np.ones(len(context)),) * 2
    out = np.empty_like(q)
    state = q[0]
    for row in range(len(q)):
        to_go = state - q[row]
        out[row] = q[row] + _left(remaining, waits[row]) * to_go
        state = q[row] + _left(remaining, spans[row]) * to_go
    return out


def _left(remaining: Array, usual_waits: float) -> Array:
    """(n,) parts of a step that are left after so many usual waits."""
    return np.sign(remaining) * np.abs(remaining) ** usual_waits


def physical(context: Context, values: Array) -> dict[str, Any]:
    """Return the parts as the simulated bench takes them, and the wait after which they are left: no servo of it
    overshoots.
    """
    parts = {f"remaining{joint + 1}": max(float(part), 0.0) for joint, part in enumerate(values[:-1])}
    return parts if context.time_s is None else {**parts, "wait_s": context.usual_wait_s}


def _parameters(context: Context, site: Site) -> tuple[Parameter, ...]:
    return (
        *(Parameter(f"remaining{joint + 1}", (-0.5, 0.98), 0.3) for joint in range(context.arm.n_joints)),
        Parameter("until_next_command", (0.0, 1.0), 1.0, scanned=True),
    )


def _starts(context: Context, site: Site, around: Array | None) -> Iterable[Array]:
    if around is not None:
        return []
    n = context.arm.n_joints
    # One way of counting is enough where all waits are alike, and where the times of the commands are known.
    one_way = context.commanded_s is not None or np.ptp(context.relative_waits[1:]) < 1e-6
    waits = (0.0,) if one_way else (0.0, 1.0)
    return [np.array([*np.full(n, fraction), wait]) for fraction in (0.003, 0.05, 0.4) for wait in waits]


# --- how the simulated bench makes it ---


# Boards that hold so tightly that neither the load nor the dry friction of the gears (4e-6 rad at a twentieth of this)
# is mixed with the lag, of which a small step leaves as little.
_STIFFNESS_NM_RAD = 100_000.0

# A whole turn within one step of the simulation: at 100 rad/s a step of 0.4 rad came 2 ms, or 3 % of its lag, too late.
_UNHURRIED_RAD_S = 10_000.0


def inject(world: World, parameters: Mapping[str, Any], joint: int | None = None, marker: str | None = None) -> World:
    """Make the servos sluggish and take each picture when it is due, arrived or not.

    `remaining1`, `remaining2`, ... (or `remaining`, for all) are the parts of a step that are still to go `wait_s`
    after the command, which is then the bench's usual time to a picture. What delays the servos is a slow filter in
    their boards; the motors could go faster.
    """
    wait_s = float(parameters.get("wait_s", world.pose_period_s))
    numbers = range(1, world.arm.n_joints + 1)
    parts = {n: float(parameters.get(f"remaining{n}", parameters["remaining"])) for n in numbers}
    servo = replace(world.servo, stiffness_nm_rad=_STIFFNESS_NM_RAD, approach_speed_rad_s=_UNHURRIED_RAD_S)

    def mechanism(spec: mujoco.MjSpec) -> None:
        for number, part in parts.items():
            spec.actuator(f"servo{number}").forcelimited = False
            if part > math.exp(-wait_s / servo.loop_time_s):  # else the loop is as quick as it can be
                bias = spec.actuator(f"servo{number}").biasprm  # 0, -stiffness, -damping
                steps = round(wait_s / spec.option.timestep)
                # Each step leaves 1 - timestep * stiffness / damping of the way, as a board that samples does.
                bias[2] = bias[1] * spec.option.timestep / (1.0 - part ** (1.0 / steps))

    sluggish = replace(world, servo=servo, waits_for_rest=False, pose_period_s=wait_s)
    return sluggish.with_mechanism(mechanism, relieved=tuple(f"joint{number}" for number in numbers))


EFFECT = Effect(
    name="settling_lag",
    summary="the picture was taken before the arm arrived",
    where="arm",
    stage=Stage.JOINT,
    parameters=_parameters,
    term=term,
    starts=_starts,
    injector=inject,
    injected=(
        Injected("remaining", (0.0, 0.99), 0.0),
        Injected("remaining{joint}", (0.0, 0.99), optional=True),
        Injected("wait_s", (0.05, 3600.0), optional=True),
    ),
    confused_with=("backlash", "hysteresis", "command_shift"),
    experiment="large and small steps to the same pose, and the same steps with a longer wait",
    plans=("growing_steps",),
    physical=physical,
    needs_return=True,
    in_time=True,
)
