"""Commands land on coarse steps: whole degrees, or few bits.

Known forms: whole degrees (Arduino's `Servo.write`, an `int`), about a zero that was trimmed joint by joint; whole or
several microseconds of pulse at each servo's own scale (`Servo.writeMicroseconds`; the PCA9685 driver's 4096 ticks of a
20 ms frame are 4.9 us, 0.4 degrees); counts of a smart servo's register (10 or 12 bits, Dynamixel and Feetech manuals).
Covered: each joint its own step and its own origin, or none; rounding to the nearest, down or up alike, since a joint's
zero takes up the difference. Not covered, and `unknown` where coarse: steps of uneven width (a potentiometer behind the
register, a logarithmic table), and lattices of the tip's coordinates instead of the joints'.
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
from armtwin.models.catalogue.registry import Effect, Evidence, Parameter, Site, Stage
from armtwin.models.catalogue.rounding import LARGEST_STEP_RAD, SMALLEST_STEP_RAD, rounded, roundings
from armtwin.models.motion_world import MotionWorld
from armtwin.models.world import Command, Electronics, World

Array = NDArray[np.float64]

# Steps met in practice: whole and half degrees, and 5 to 8 bits over half a turn.
_USUAL_STEPS = tuple(np.radians([0.5, 1.0, 2.0, 3.0, 5.0])) + tuple(np.pi / 2**bits for bits in range(5, 9))
# Steps and origins that are looked at for one joint, in a recording of a few hundred poses over a radian.
_LOOKED_AT = 20_000.0


def term(context: Context, q: Array, values: Array, site: Site) -> Array:
    """Commands on each joint's lattice: `values` are (step, origin) of joint 1, 2, ..., rad; a step of 0 is none."""
    out = q.copy()
    for joint, (step, origin) in enumerate(values.reshape(-1, 2)):
        if step > 0:
            out[:, joint] = rounded(q[:, joint], step, origin)
    return out


def complexity(context: Context, values: Array) -> float:
    """Twice the logarithm of the lattices that were looked at, for each joint that has one."""
    return 2.0 * float(np.log(_LOOKED_AT)) * int((values[::2] > 0).sum())


def told(context: Context, values: Array) -> list[int]:
    """Return which values are of joints that have a lattice."""
    return [k for k in range(len(values)) if values[k & ~1] > 0]


def _parameters(context: Context, site: Site) -> tuple[Parameter, ...]:
    return tuple(
        parameter
        for number in range(1, context.arm.n_joints + 1)
        for parameter in (
            Parameter(f"step{number}_rad", (0.0, LARGEST_STEP_RAD), 0.02, scanned=True),
            Parameter(f"origin{number}_rad", (-0.5 * LARGEST_STEP_RAD, 0.5 * LARGEST_STEP_RAD), 0.01, scanned=True),
        )
    )


def _starts(context: Context, site: Site, around: Array | None) -> Iterable[Array]:
    """Return one step for all joints, counted from their zeros; `_screen` finds those of each joint."""
    if around is not None or context.camera is None:  # of measured angles the screen sees every step
        return []
    return [np.tile([step, 0.0], context.arm.n_joints) for step in _USUAL_STEPS if step > SMALLEST_STEP_RAD]


def _screen(context: Context, site: Site, evidence: Evidence) -> Iterable[Array]:
    """Return the lattices that the residual of the joint angles shows."""
    values = np.zeros((context.arm.n_joints, 2))
    for joint, one in enumerate(roundings(evidence)):
        if one is not None:  # the same lattice may be counted from any of its points: from the one nearest to zero
            values[joint] = one.step_rad, one.origin_rad - np.round(one.origin_rad / one.step_rad) * one.step_rad
    return [values.ravel()] if values.any() else []


# --- how the simulated bench makes it ---


def inject(world: World, parameters: Mapping[str, Any], site: Site) -> World:
    """Let the sender write every command as a whole number of counts of its joint.

    A count of joint N is `stepN_rad` wide (or `step_rad`, for all that state none; 0 is exact), and one of them lies at
    `originN_rad`.
    """
    numbers = range(1, world.arm.n_joints + 1)
    wide = [float(parameters.get(f"step{n}_rad", parameters["step_rad"])) for n in numbers]
    first = [float(parameters[f"origin{n}_rad"]) for n in numbers]

    def sender() -> Electronics:
        def receive(command: Command) -> NDArray[np.float64]:
            written = [
                float(angle) if width == 0.0 else zero + width * round((float(angle) - zero) / width)
                for angle, width, zero in zip(command.q, wide, first, strict=True)
            ]
            return np.array(written)

        return receive

    return world.with_electronics(sender)


def _hide(rng: Generator, s: sealed.Situation) -> sealed.Hidden:
    """Draw one step for all servos, or one each; counted from each joint's zero or from where it was trimmed."""
    n = s.arm.n_joints
    scales = rng.uniform(0.8, 1.25, n) if rng.random() < 0.4 else np.ones(n)
    trims = rng.uniform(-0.5, 0.5, n) if rng.random() < 0.7 else np.zeros(n)  # in steps

    def parameters(a: float) -> dict[str, Any]:
        steps = {f"step{j + 1}_rad": float(a * scales[j]) for j in range(n)}
        return steps | {f"origin{j + 1}_rad": float(a * scales[j] * trims[j]) for j in range(n)}

    return sealed.Hidden(parameters, 0.0175, 0.12)


EFFECT = Effect(
    name="quantization",
    summary="commands land on coarse steps (whole degrees, few bits)",
    where="arm",
    stage=Stage.COMMAND,
    parameters=_parameters,
    term=term,
    starts=_starts,
    injector=inject,
    injected=(
        Injected("step_rad", (0.0, 1.6), 0.0),
        Injected("step{joint}_rad", (0.0, 1.6), optional=True),
        Injected("origin{joint}_rad", (-1.6, 1.6), 0.0),
    ),
    screen=_screen,
    complexity=complexity,
    told=told,
    confused_with=("dead_band", "servo_nonlinearity"),
    experiment="a fine ramp of each joint over several steps",
    plans=("fine_ramp",),
    sealed=sealed.Sealing(_hide),
)


def inject_in_motion(world: MotionWorld, parameters: Mapping[str, Any], site: Site) -> MotionWorld:
    """Let the sender write every command of `joint` as a whole number of counts, one of which lies at `origin_rad`."""
    (index,) = world.joints_at(site)
    width, zero = float(parameters["step_rad"]), float(parameters["origin_rad"])
    return world if width == 0.0 else world.with_values(index, lambda q: zero + width * np.round((q - zero) / width))


IN_MOTION = MotionEffect(
    name=EFFECT.name,
    summary=EFFECT.summary,
    where="joint",
    forms=(
        (
            Slot("step_rad", "step_rad", (0.0005, 0.6), (), 0.002, scanned=True),
            Slot("origin_rad", "step_origin_rad", (-0.6, 0.6), (), 0.001, scanned=True),
        ),
    ),
    confused_with=EFFECT.confused_with,
    experiment=EFFECT.experiment,
    motions=("reversals",),
    injector=inject_in_motion,
    injected=(Injected("step_rad", (0.0, 1.6)), Injected("origin_rad", (-1.6, 1.6), 0.0)),
)
