"""A zero that creeps with time and settles.

The term is a first-order rise. Where no time was recorded, one pose counts as one second.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from armtwin.models.catalogue import sealed
from armtwin.models.catalogue.context import Context
from armtwin.models.catalogue.injection import Injected
from armtwin.models.catalogue.registry import Effect, Parameter, Site, Stage
from armtwin.models.world import Command, Electronics, World, joint_index

Array = NDArray[np.float64]


def term(context: Context, q: Array, values: Array, site: Site) -> Array:
    """Angles whose zero creeps by `drift_rad` with `time_constant_s`."""
    drift, constant = values
    assert site.joint is not None
    out = q.copy()
    out[:, site.joint - 1] -= drift * np.expm1(-context.elapsed_s / constant)
    return out


def _parameters(context: Context, site: Site) -> tuple[Parameter, ...]:
    span = float(context.elapsed_s[-1])
    return (
        Parameter("drift_rad", (-0.3, 0.3), 0.03),
        Parameter("time_constant_s", (0.01 * span, 3.0 * span), span, off=None),
    )


def _starts(context: Context, site: Site, around: Array | None) -> Iterable[Array]:
    span = float(context.elapsed_s[-1])
    return [] if around is not None else [np.array([0.0, part * span]) for part in (0.05, 0.12, 0.3, 0.8, 2.0)]


# --- how the simulated bench makes it ---


# The winding warms this much faster than the case.
_WINDING_SHARE = 0.01


def inject(world: World, parameters: Mapping[str, Any], site: Site) -> World:
    """Let the servo of `joint` warm up from cold; its potentiometer's mount moves with the case's warmth.

    Two heat stores in a row, winding and case. Once the winding is warm, the case settles with `time_constant_s`, and
    what the zero moves by meanwhile is `drift_rad`. Warming starts with the first command.
    """
    index = joint_index(world, site)
    drift, time_constant = float(parameters["drift_rad"]), float(parameters["time_constant_s"])

    def warming() -> Electronics:
        clock: float | None = None
        winding = case = 1.0  # warmth that is still lacking, 0 at the end

        def receive(command: Command) -> NDArray[np.float64]:
            nonlocal clock, winding, case
            passed = (command.time_s - (command.time_s if clock is None else clock)) / time_constant
            clock = command.time_s
            # The case follows the winding, d case/dt = (winding - case) / time_constant: solved since the last command.
            slow, quick = math.exp(-passed), math.exp(-passed / _WINDING_SHARE)
            case = case * slow + winding * _WINDING_SHARE / (1.0 - _WINDING_SHARE) * (slow - quick)
            winding *= quick
            q = command.q.copy()
            q[index] += drift * (1.0 - _WINDING_SHARE) * (1.0 - case)  # the slow mode weighs 1 / (1 - share)
            return q

        return receive

    return world.with_electronics(warming)


def _hide(rng: Generator, s: sealed.Situation) -> sealed.Hidden:
    """Draw how it is hidden in a sealed world."""
    sign, constant = sealed.sign(rng), float(rng.uniform(0.08, 0.5)) * s.span_s
    return sealed.Hidden(
        lambda a: {"drift_rad": sign * a, "time_constant_s": constant}, 0.01, 0.2, sealed.any_joint(rng, s)
    )


EFFECT = Effect(
    name="thermal_drift",
    summary="a zero that creeps with time and settles",
    where="joint",
    stage=Stage.JOINT,
    parameters=_parameters,
    term=term,
    starts=_starts,
    injector=inject,
    injected=(Injected("drift_rad", (-1.0, 1.0)), Injected("time_constant_s", (1e-3, 1e9))),
    confused_with=("camera_drift", "joint_slip"),
    experiment="one pose repeated now and then over a long time",
    plans=("repeat_pose",),
    needs_return=True,
    in_time=True,
    sealed=sealed.Sealing(_hide, timed=True),
)
