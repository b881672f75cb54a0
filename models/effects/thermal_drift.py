"""A zero that creeps with time and settles.

Known forms: a servo that warms up, winding and case each at its own pace (two heat stores in series settle with two
time constants: any text on motor thermal models); plastic that creeps under load, quick at first and never done (W.
Findley's power law; over one recording two exponentials follow it to a few hundredths); a steady crawl, of which only
the beginning of an exponential is seen; a zero that follows the room's temperature up and down. Covered: one time
constant or two, each up to ten times the recording, and what is proportional to the temperature where it was recorded.
Not covered: warmth that depends on how hard the arm worked, or that goes on and off with it (`unknown` where plain).

The term is a sum of first-order rises. Where no time was recorded, one pose counts as one second.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from armtwin.models.catalogue import sealed
from armtwin.models.catalogue.context import Context
from armtwin.models.catalogue.injection import Injected
from armtwin.models.catalogue.motion_effect import MotionEffect, Slot
from armtwin.models.catalogue.registry import Effect, Parameter, Site, Stage
from armtwin.models.motion_world import MotionWorld, Wire
from armtwin.models.world import Command, Electronics, World, joint_index

Array = NDArray[np.float64]


# Of the recording's span: the shortest and longest time constants.
_SHORTEST, _LONGEST = 0.01, 10.0


def term(context: Context, q: Array, values: Array, site: Site) -> Array:
    """Angles whose zero creeps by `drift_rad` with `time_constant_s`, maybe by a second one, and with the warmth."""
    drift, constant, later, later_constant, twice = values[:5]
    assert site.joint is not None
    creep = -drift * np.expm1(-context.elapsed_s / constant)
    if twice:
        creep = creep - later * np.expm1(-context.elapsed_s / later_constant)
    if len(values) > _TEMPERATURE:
        creep = creep + values[_TEMPERATURE] * _warmer(context)
    out = q.copy()
    out[:, site.joint - 1] += creep
    return out


# Index of the last value, which is there where a temperature was recorded.
_TEMPERATURE = 5


def _warmer(context: Context) -> Array:
    """(N,) kelvin above the first temperature that was recorded; what was not recorded is taken to be as before it."""
    assert context.temperature_c is not None
    known = np.isfinite(context.temperature_c)
    rows = np.flatnonzero(known)
    filled = np.interp(np.arange(len(known)), rows, context.temperature_c[rows])
    out: Array = filled - filled[0]
    return out


def _has_temperature(context: Context) -> bool:
    if context.temperature_c is None or np.isfinite(context.temperature_c).sum() < 2:
        return False
    return bool(np.ptp(_warmer(context)) > _LEAST_KELVIN)


# A smaller change of temperature moves no zero by a tenth of a degree.
_LEAST_KELVIN = 0.5


def told(context: Context, values: Array) -> list[int]:
    """Leave out the second creep where there is none."""
    return [k for k in range(len(values)) if values[4] or k not in (2, 3, 4)]


def complexity(context: Context, values: Array) -> float:
    """Of each number that acts the logarithm of the rows; the starts are few."""
    return (len(values) - 1 - (0 if values[4] else 2)) * float(np.log(2 * len(context)))


def physical(context: Context, values: Array) -> dict[str, Any]:
    """Return the creeps that act as the simulated bench takes them; it holds no temperature."""
    built = {"drift_rad": float(values[0]), "time_constant_s": float(values[1])}
    return built | ({"later_rad": float(values[2]), "later_constant_s": float(values[3])} if values[4] else {})


def _parameters(context: Context, site: Site) -> tuple[Parameter, ...]:
    span = float(context.elapsed_s[-1])
    constants = (_SHORTEST * span, _LONGEST * span)
    follows = (Parameter("per_kelvin_rad", (-0.05, 0.05), 0.003),) if _has_temperature(context) else ()
    return (
        Parameter("drift_rad", (-1.0, 1.0), 0.03),
        Parameter("time_constant_s", constants, span, off=None),
        Parameter("later_rad", (-1.0, 1.0), 0.03),
        Parameter("later_constant_s", constants, span, off=None),
        Parameter("settles_twice", (0.0, 1.0), 1.0, scanned=True),
        *follows,
    )


def _starts(context: Context, site: Site, around: Array | None) -> Iterable[Array]:
    if around is not None:
        return []
    span, rest = float(context.elapsed_s[-1]), [0.0] * _has_temperature(context)
    once = [[0.0, part * span, 0.0, span, 0.0, *rest] for part in (0.05, 0.12, 0.3, 0.8, 2.0)]
    twice = [
        [0.0, quick * span, 0.0, slow * span, 1.0, *rest]
        for quick, slow in ((0.03, 0.3), (0.03, 2.0), (0.08, 0.6), (0.15, 3.0))
    ]
    return [np.array(values) for values in (*once, *twice)]


# --- how the simulated bench makes it ---


# The winding warms this much faster than the case.
_WINDING_SHARE = 0.01


def inject(world: World, parameters: Mapping[str, Any], site: Site) -> World:
    """Let the servo of `joint` warm up from cold; its potentiometer's mount moves with the case's warmth.

    Two heat stores in a row, winding and case. Once the winding is warm, the case settles with `time_constant_s`, and
    what the zero moves by meanwhile is `drift_rad`. With `later_rad` the frame that holds the servo warms as well, and
    turns it by so much with `later_constant_s`. Warming starts with the first command.
    """
    index = joint_index(world, site)
    stores = [(float(parameters["drift_rad"]), float(parameters["time_constant_s"]))]
    if "later_rad" in parameters:
        stores.append((float(parameters["later_rad"]), float(parameters["later_constant_s"])))

    def warming() -> Electronics:
        warmths = [_Warmth(constant) for _, constant in stores]

        def receive(command: Command) -> NDArray[np.float64]:
            q = command.q.copy()
            q[index] += sum(drift * one.at(command.time_s) for (drift, _), one in zip(stores, warmths, strict=True))
            return q

        return receive

    return world.with_electronics(warming)


class _Warmth:
    """A case that follows its winding, d case/dt = (winding - case) / time_constant, solved since the last look."""

    def __init__(self, time_constant_s: float) -> None:
        self._constant = time_constant_s
        self._clock: float | None = None
        self._winding = self._case = 1.0  # warmth that is still lacking, 0 at the end

    def at(self, time_s: float) -> float:
        """Warmth of the case at a time, not before the last one: the slow mode's share of it, 0 to 1."""
        passed = (time_s - (time_s if self._clock is None else self._clock)) / self._constant
        self._clock = time_s
        slow, quick = math.exp(-passed), math.exp(-passed / _WINDING_SHARE)
        self._case = self._case * slow + self._winding * _WINDING_SHARE / (1.0 - _WINDING_SHARE) * (slow - quick)
        self._winding *= quick
        return (1.0 - _WINDING_SHARE) * (1.0 - self._case)  # the slow mode weighs 1 / (1 - share)


def _hide(rng: Generator, s: sealed.Situation) -> sealed.Hidden:
    """Draw a drift that settles, some with a second one that takes longer or does not end."""
    sign, constant = sealed.sign(rng), float(rng.uniform(0.08, 0.5)) * s.span_s
    slower, share = float(rng.uniform(4.0, 8.0)) * constant, float(rng.uniform(0.5, 1.5))
    twice = rng.random() < 0.4

    def parameters(a: float) -> dict[str, Any]:
        later = {"later_rad": sign * share * a, "later_constant_s": slower} if twice else {}
        return {"drift_rad": sign * a, "time_constant_s": constant, **later}

    return sealed.Hidden(parameters, 0.01, 0.2, sealed.any_joint(rng, s))


EFFECT = Effect(
    name="thermal_drift",
    summary="a zero that creeps with time and settles",
    where="joint",
    stage=Stage.JOINT,
    parameters=_parameters,
    term=term,
    starts=_starts,
    injector=inject,
    injected=(
        Injected("drift_rad", (-1.0, 1.0)),
        Injected("time_constant_s", (1e-3, 1e9)),
        Injected("later_rad", (-1.0, 1.0), optional=True),
        Injected("later_constant_s", (1e-3, 1e9), 1.0),
    ),
    confused_with=("camera_drift", "joint_slip"),
    experiment="one pose repeated now and then over a long time",
    plans=("repeat_pose",),
    physical=physical,
    complexity=complexity,
    told=told,
    needs_return=True,
    when_correcting="is reckoned from a cold start, one pose every 1.5 s",
    in_time=True,
    sealed=sealed.Sealing(_hide, timed=True),
)


def inject_in_motion(world: MotionWorld, parameters: Mapping[str, Any], site: Site) -> MotionWorld:
    """Let the servo of `joint` warm up from cold, as in `inject`, or creep on by `creep_rad_per_s`.

    Warming starts with the first command.
    """
    (index,) = world.joints_at(site)
    drift, constant = float(parameters["drift_rad"]), float(parameters["time_constant_s"])
    creep = float(parameters["creep_rad_per_s"])

    def warming(wires: Sequence[Wire]) -> list[Wire]:
        out = list(wires)
        wire = out[index]
        passed = np.maximum(wire.time_s - wire.time_s[1], 0.0)
        warmth = _Warmth(constant)
        moved = np.array([drift * warmth.at(moment) + creep * moment for moment in passed.tolist()])
        out[index] = replace(wire, q=wire.q + moved)
        return out

    return world.with_wiring(warming)


IN_MOTION = MotionEffect(
    name=EFFECT.name,
    summary=EFFECT.summary,
    where="joint",
    forms=(
        (
            Slot("drift_rad", "drift_rad", (-0.5, 0.5), (0.0,), 0.002),
            Slot("time_constant_s", "drift_s", (2.0, 3000.0), (10.0, 60.0), 5.0),
        ),
        (Slot("creep_rad_per_s", "creep_rad_s", (-0.05, 0.05), (0.0,), 1e-05),),
    ),
    confused_with=("joint_slip", "servo_gain"),
    experiment="one pose held now and then over a long time",
    motions=("holds",),
    injector=inject_in_motion,
    injected=(
        Injected("drift_rad", (-1.0, 1.0), 0.0),
        Injected("time_constant_s", (1e-3, 1e9), 1.0),
        Injected("creep_rad_per_s", (-1.0, 1.0), 0.0),
    ),
)
