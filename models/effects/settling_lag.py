"""The picture was taken before the arm arrived.

Known forms: a loop that leaves a share of each step (a first-order lag; design of the diagnosis, section 8); a servo
whose speed is limited, by its motor or by a register, and that has covered so much of the way and no more; both, a
loop whose output saturates far from its goal. Covered: all three, a share for each joint and one speed for the arm, at
rest or not when the next command comes. Not covered: a ramp planned over all joints so that all arrive at once, ringing
that lasts until the picture (`unknown` where either leaves more than a few hundredths of the step).

The term is a first-order approach whose speed saturates. Where no times of commands were recorded, a bench may have
waited equally long before every picture, or taken it when the next command was due, or gone on some time after it.
"""

from __future__ import annotations

import math
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
from armtwin.models.catalogue.registry import Effect, Parameter, Site, Stage
from armtwin.models.world import World

Array = NDArray[np.float64]


# Rad in a usual wait beyond which a servo's speed limits nothing.
_UNLIMITED_RAD = 6.0


def term(context: Context, q: Array, values: Array, site: Site) -> Array:
    """Angles that lack a part of each step: `values` are the parts left (n,), reach, pause, and until_next_command."""
    remaining, (reach, pause, until_next) = np.clip(values[:-3], -0.95, 0.99), values[-3:]
    timed = bool(until_next) or context.commanded_s is not None
    waits, spans = (context.relative_waits, context.relative_spans) if timed else (np.ones(len(context)),) * 2
    if context.commanded_s is None:
        spans = spans + pause
    out = np.empty_like(q)
    for joint, part in enumerate(remaining.tolist()):
        path = q[:, joint].tolist()
        if reach >= _UNLIMITED_RAD:
            seen, kept = _left(part, waits).tolist(), _left(part, spans).tolist()
            out[:, joint] = q[:, joint] + _by_share(path, seen, kept)
        else:
            out[:, joint] = q[:, joint] + _by_speed(path, waits, spans, part, float(reach))
    return out


def _left(part: float, usual_waits: Array) -> Array:
    """(N,) parts of a step that are left after so many usual waits."""
    out: Array = np.sign(part) * np.abs(part) ** usual_waits
    return out


def _by_share(path: list[float], seen: list[float], kept: list[float]) -> list[float]:
    """What is left to go when each row is seen, where a step leaves parts of itself."""
    to_go, before, out = 0.0, path[0], []
    for goal, at_sight, at_next in zip(path, seen, kept, strict=True):
        to_go += before - goal
        out.append(at_sight * to_go)
        to_go *= at_next
        before = goal
    return out


def _by_speed(path: list[float], waits: Array, spans: Array, part: float, reach: float) -> list[float]:
    """The same for a servo that covers no more than `reach` in a usual wait; close to its goal it goes by shares."""
    if part == 0.0:
        return _by_speed_alone(path, (reach * waits).tolist(), (reach * spans).tolist())
    slow = 1.0 / -math.log(max(abs(part), 1e-9))  # time constant, usual waits
    near = reach * slow  # way to go from which on the speed is no limit

    to_go, before, out = 0.0, path[0], []
    for goal, wait, span in zip(path, waits.tolist(), spans.tolist(), strict=True):
        to_go += before - goal
        before = goal
        way = to_go if to_go >= 0 else -to_go
        late, last = [
            way - reach * time
            if way - reach * time > near
            else (near if way > near else way) * math.exp(-(time - (max(way - near, 0.0) / reach)) / slow)
            for time in (wait, span)
        ]
        out.append(late if to_go >= 0 else -late)
        to_go = last if to_go >= 0 else -last
    return out


def _by_speed_alone(path: list[float], seen: list[float], kept: list[float]) -> list[float]:
    """The same for one that stops at its goal at once, by the ways that it covers until each row and next command."""
    to_go, before, out = 0.0, path[0], []
    for goal, at_sight, at_next in zip(path, seen, kept, strict=True):
        to_go += before - goal
        before = goal
        out.append(to_go - min(max(to_go, -at_sight), at_sight))
        to_go -= min(max(to_go, -at_next), at_next)
    return out


def physical(context: Context, values: Array) -> dict[str, Any]:
    """Return the parts as the simulated bench takes them, and the wait after which they are left: no servo of it
    overshoots.
    """
    parts = {f"remaining{joint + 1}": max(float(part), 0.0) for joint, part in enumerate(values[:-3])}
    if values[-3] < _UNLIMITED_RAD:
        parts["reach_rad"] = float(values[-3])
    return parts if context.time_s is None else {**parts, "wait_s": context.usual_wait_s}


def told(context: Context, values: Array) -> list[int]:
    """Leave out a speed that limits nothing, parts beside a speed alone, and the pause where it is known."""
    n = len(values) - 3
    idle = {n} if values[n] >= _UNLIMITED_RAD else set()
    if _speed_alone(values):
        idle |= set(range(n))
    return [k for k in range(len(values)) if k not in idle and not (k == n + 1 and context.commanded_s is not None)]


def _speed_alone(values: Array) -> bool:
    """Whether the servos stop at their goals at once, and only their speed is a limit."""
    return bool(values[-3] < _UNLIMITED_RAD and not values[:-3].any())


def complexity(context: Context, values: Array) -> float:
    """Of the joints' parts, a speed that limits and a pause: the logarithm of the rows, and what starts were tried."""
    parts = 0 if _speed_alone(values) else len(values) - 3
    smooth = parts + 2 * int(values[-3] < _UNLIMITED_RAD) + int(values[-2] > 0)
    return (smooth + 2) * float(np.log(len(context))) + smooth * float(np.log(4.0))


def _parameters(context: Context, site: Site) -> tuple[Parameter, ...]:
    return (
        *(Parameter(f"remaining{joint + 1}", (-0.5, 0.98), 0.3) for joint in range(context.arm.n_joints)),
        Parameter("reach_rad", (0.003, 1.1 * _UNLIMITED_RAD), 0.3, off=None),
        Parameter("pause", (0.0, 20.0), 3.0),
        Parameter("until_next_command", (0.0, 1.0), 1.0, scanned=True),
    )


def _starts(context: Context, site: Site, around: Array | None) -> Iterable[Array]:
    if around is not None:
        return []
    n = context.arm.n_joints
    # One way of counting is enough where all waits are alike, and where the times of the commands are known.
    one_way = context.commanded_s is not None or np.ptp(context.relative_waits[1:]) < 1e-6
    waits = (0.0,) if one_way else (0.0, 1.0)
    free = 1.1 * _UNLIMITED_RAD
    shares = [(part, free, 0.0) for part in (0.003, 0.05, 0.4)] + [(0.05, free, 3.0)]
    speeds = [(part, reach, 0.0) for part in (0.0, 0.003, 0.2) for reach in _reaches(context)]
    return [np.array([*np.full(n, part), reach, pause, w]) for part, reach, pause in shares + speeds for w in waits]


def _reaches(context: Context) -> list[float]:
    """Ways that some of the moves exceed and others do not."""
    moves = np.abs(np.diff(context.q_cmd, axis=0)).ravel()
    moves = moves[moves > 1e-6]
    return [float(way) for way in np.quantile(moves, (0.35, 0.65, 0.9))] if len(moves) else []


# --- how the simulated bench makes it ---


# Boards that hold so tightly that neither the load nor the dry friction of the gears (4e-6 rad at a twentieth of this)
# is mixed with the lag, of which a small step leaves as little.
_STIFFNESS_NM_RAD = 100_000.0

# A whole turn within one step of the simulation: at 100 rad/s a step of 0.4 rad came 2 ms, or 3 % of its lag, too late.
_UNHURRIED_RAD_S = 10_000.0


def inject(world: World, parameters: Mapping[str, Any], site: Site) -> World:
    """Make the servos sluggish or slow, and take each picture when it is due, arrived or not.

    `remaining1`, `remaining2`, ... (or `remaining`, for all) are the parts of a step that are still to go `wait_s`
    after the command, which is then the bench's usual time to a picture. What delays the servos is a slow filter in
    their boards; the motors could go faster. With `reach_rad` they cannot: they turn by no more than that in `wait_s`.
    """
    wait_s = float(parameters.get("wait_s", world.pose_period_s))
    numbers = range(1, world.arm.n_joints + 1)
    parts = {n: float(parameters.get(f"remaining{n}", parameters["remaining"])) for n in numbers}
    speed = float(parameters["reach_rad"]) / wait_s if "reach_rad" in parameters else _UNHURRIED_RAD_S
    servo = replace(world.servo, stiffness_nm_rad=_STIFFNESS_NM_RAD, approach_speed_rad_s=speed)

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


def _hide(rng: Generator, s: sealed.Situation) -> sealed.Hidden:
    """Draw shares of each step that are left, or a speed with which long moves do not arrive."""
    shares = rng.uniform(0.5, 1.0, s.arm.n_joints)
    if rng.random() < 0.6:
        return sealed.Hidden(lambda a: {f"remaining{j + 1}": a * v for j, v in enumerate(shares)}, 0.1, 0.6)
    tail = float(rng.uniform(0.0, 0.2))
    # The slower, the farther off: the amplitude is the part of a stroke of 0.3 rad that a servo does not get through.
    slow = {f"remaining{j + 1}": tail * float(v) for j, v in enumerate(shares)}
    return sealed.Hidden(lambda a: {**slow, "reach_rad": 0.3 * (1.0 - a)}, 0.3, 0.9)


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
        Injected("reach_rad", (1e-3, 10.0), optional=True),
    ),
    confused_with=("backlash", "hysteresis", "command_shift"),
    experiment="large and small steps to the same pose, and the same steps with a longer wait",
    plans=("growing_steps",),
    physical=physical,
    complexity=complexity,
    told=told,
    needs_return=True,
    when_correcting="the arm is given the time that it needs",
    in_time=True,
    sealed=sealed.Sealing(_hide),
)
