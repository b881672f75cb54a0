"""The servo ignores a command change smaller than a threshold and stays where it was.

Known forms: a control board that leaves the motor off within a band (hobby servos' data sheets: 1 to 10 us) and
drives all the way once it drives; one whose motor stops somewhat short, since the last of the way is within the band;
one that stops as soon as the band's edge is reached, which moves exactly as play does. Covered: any threshold, and
stopping short by up to half of it. Named otherwise: a servo that stops at the edge is told as `backlash`, from which no
recording tells it. Not covered: a band that depends on the load (`unknown` where it varies by more than some steps).
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
from armtwin.models.catalogue.thresholds import thresholds_in
from armtwin.models.motion_world import MotionWorld
from armtwin.models.world import Command, Electronics, World, joint_index

Array = NDArray[np.float64]

# Beyond this no servo is usable; below, no servo of this size resolves a change (a tenth of a pulse's microsecond).
_WIDEST_RAD = 0.2
_LEAST_RAD = 1e-4


def term(context: Context, q: Array, values: Array, site: Site) -> Array:
    """Angles of a servo that moves only when the command leaves it by at least `threshold_rad`, and may stop short."""
    assert site.joint is not None
    out = q.copy()
    out[:, site.joint - 1] = _held(q[:, site.joint - 1], float(values[0]), float(values[1]))
    return out


def _held(path: Array, threshold: float, stops_short: float = 0.0) -> Array:
    """(N,) angles that a servo holds along a path of commands; it stops short by a share of the threshold."""
    out, held, rest = [], float(path[0]), stops_short * threshold
    for angle in path.tolist():
        if angle - held >= threshold:
            held = angle - rest
        elif held - angle >= threshold:
            held = angle + rest
        out.append(held)
    return np.array(out)


def _parameters(context: Context, site: Site) -> tuple[Parameter, ...]:
    return (
        Parameter("threshold_rad", (0.0, _WIDEST_RAD), 0.03, scanned=True),
        Parameter("stops_short", (0.0, 0.5), 0.2),
    )


def complexity(context: Context, values: Array) -> float:
    """Twice the logarithm of the thresholds that tell commands apart, and the rows' for stopping short."""
    return (2.0 + (values[1] > _SHORT)) * float(np.log(len(context)))


# Of the threshold: less is not worth a number.
_SHORT = 0.005


def _starts(context: Context, site: Site, around: Array | None) -> Iterable[Array]:
    """Return none: `_screen` looks at every threshold at once."""
    return []


def _screen(context: Context, site: Site, evidence: Evidence) -> Iterable[Array]:
    """Return the thresholds that the joint's departures show."""
    assert site.joint is not None
    path = evidence.commands[:, site.joint - 1]
    return thresholds_in(path, *evidence.departures(site.joint - 1), _WIDEST_RAD, _LEAST_RAD)


# --- how the simulated bench makes it ---


def inject(world: World, parameters: Mapping[str, Any], site: Site) -> World:
    """Give the servo of `joint` a control board that leaves the motor off for changes below `threshold_rad`.

    The board compares the pulse with the angle it holds; once it drives, it drives until the rest of the way is the
    share `stops_short` of the threshold.
    """
    index = joint_index(world, site)
    threshold = float(parameters["threshold_rad"])
    rest = float(parameters["stops_short"]) * threshold

    def board() -> Electronics:
        held: float | None = None  # switched on by the first pulse

        def receive(command: Command) -> NDArray[np.float64]:
            nonlocal held
            wanted = float(command.q[index])
            if held is None:
                held = wanted
            elif abs(wanted - held) >= threshold:
                held = wanted - rest if wanted > held else wanted + rest
            q = command.q.copy()
            q[index] = held
            return q

        return receive

    return world.with_electronics(board)


def _hide(rng: Generator, s: sealed.Situation) -> sealed.Hidden:
    """Draw a threshold; some servos stop short of their command."""
    short = float(rng.uniform(0.05, 0.4)) if rng.random() < 0.4 else 0.0
    return sealed.Hidden(lambda a: {"threshold_rad": a, "stops_short": short}, 0.02, 0.15, sealed.any_joint(rng, s))


EFFECT = Effect(
    name="dead_band",
    summary="the servo ignores a command change smaller than a threshold",
    where="joint",
    stage=Stage.SERVO,
    parameters=_parameters,
    term=term,
    starts=_starts,
    injector=inject,
    injected=(Injected("threshold_rad", (0.0, 1.0)), Injected("stops_short", (0.0, 1.0), 0.0)),
    confused_with=("backlash", "quantization", "missed_command"),
    experiment="steps of this joint that grow from far below to far above the threshold, in both directions",
    plans=("reversal", "growing_steps"),
    screen=_screen,
    complexity=complexity,
    needs_return=True,
    sealed=sealed.Sealing(_hide),
)


def inject_in_motion(world: MotionWorld, parameters: Mapping[str, Any], site: Site) -> MotionWorld:
    """Give the drive of `joint` a control board that leaves the motor off for changes below `threshold_rad`."""
    (index,) = world.joints_at(site)
    threshold = float(parameters["threshold_rad"])
    rest = float(parameters["stops_short"]) * threshold

    def board(q: Array) -> Array:
        held, out = float(q[0]), np.empty_like(q)
        for k, wanted in enumerate(q.tolist()):
            if abs(wanted - held) >= threshold:
                held = wanted - rest if wanted > held else wanted + rest
            out[k] = held
        return out

    return world.with_values(index, board)


IN_MOTION = MotionEffect(
    name=EFFECT.name,
    summary=EFFECT.summary,
    where="joint",
    forms=(
        (
            Slot(
                "threshold_rad",
                "dead_band_rad",
                (0.0, 0.3),
                (0.004, 0.007, 0.01, 0.015, 0.02, 0.03, 0.05, 0.08),
                0.003,
                scanned=True,
            ),
        ),
    ),
    confused_with=("quantization", "friction", "missed_command"),
    experiment=EFFECT.experiment,
    motions=("reversals", "holds"),
    injector=inject_in_motion,
    injected=(Injected("threshold_rad", (0.0, 1.0)), Injected("stops_short", (0.0, 1.0), 0.0)),
)
