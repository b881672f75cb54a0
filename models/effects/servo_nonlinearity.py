"""A smooth or periodic error over a joint's angle.

Known forms: a potentiometer whose track is not linear (smooth, of low order, some per cent of its span), a gear bored
off its centre and uneven worms or belts (periodic, one cycle a turn of the part, with overtones), the sine of a horn's
linkage. The term has two forms: one harmonic of the commanded angle with free frequency, or a track, a curve of the
third order that holds a wrong gain as well, so that a gain with a curve is one cause. Where a joint was seen at few
different angles, from which no frequency can be told, it is a slope and a curvature.
Not covered: several frequencies of like size, and a dead spot of the track in one place (`unknown`).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
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
from armtwin.models.errors import InputError
from armtwin.models.motion_world import MotionWorld
from armtwin.models.world import Command, Electronics, World, joint_index

Array = NDArray[np.float64]


# A gear whose bore lies nearer to its rim than this part of its radius does not hold together.
_MOST_ECCENTRIC = 0.95
# Errors of less than one cycle over the range of a hobby servo are smooth; gears repeat up to some thirty times.
_CYCLES = (1.0, 2.0, 3.0, 4.0, 6.0, 8.0, 10.0, 12.0, 15.0, 18.0, 22.0, 26.0, 30.0, 36.0)


# With fewer different angles a harmonic of free frequency passes through anything.
_FEW_ANGLES = 12
# Parameters of a potentiometer's track, derivatives of its error at zero; of few angles the first two are told.
_TRACK = ("slope", "curvature_per_rad", "third_per_rad2")
_FEW_TRACK = 2
_BEND = 2
# Where they stand among the values, after sine, cosine and cycles; the last value says whether it is a track.
_AT = 3
# Pieces of the track that the simulated bench is wound of, over a servo's travel.
_PIECES = 2001
# No track is wound closer or wider than this, times the usual: a curve of the third order goes astray off the poses.
_WINDING = (0.1, 3.0)


def term(context: Context, q: Array, values: Array, site: Site) -> Array:
    """Angles with an error of sine and cosine of `cycles_per_turn` times the joint's angle."""
    assert site.joint is not None
    joint = site.joint - 1
    out = q.copy()
    track = _track(values)
    if track is not None:
        power, angle = np.ones(len(q)), q[:, joint]
        for order, derivative in enumerate(track, start=1):
            power = power * angle / order
            out[:, joint] += derivative * power
        return out
    sine, cosine, cycles = values[:_AT]
    out[:, joint] += sine * np.sin(cycles * q[:, joint]) + cosine * np.cos(cycles * q[:, joint])
    return out


def physical(context: Context, values: Array) -> dict[str, Any]:
    """Return amplitude, frequency and phase, as the simulated bench takes them: at most what a gear can make."""
    track = _track(values)
    if track is not None:
        return {name: float(value) for name, value in zip(_TRACK, track, strict=False)}
    sine, cosine, cycles = values[:_AT]
    return {
        "amplitude_rad": min(float(np.hypot(sine, cosine)), _MOST_ECCENTRIC / float(cycles)),
        "cycles_per_turn": float(cycles),
        "phase_rad": float(np.arctan2(cosine, sine)),
    }


def _track(values: Array) -> Array | None:
    """Return the derivatives (2 or 3,) of a track, or None where the values are of a harmonic."""
    if len(values) == _FEW_TRACK:
        return values
    return values[_AT:-1] if values[-1] else None


def told(context: Context, values: Array) -> list[int]:
    """Leave out the form that it does not have."""
    if len(values) == _FEW_TRACK:
        return [0, 1]
    return list(range(_AT, len(values) - 1)) if values[-1] else list(range(_AT))


def complexity(context: Context, values: Array) -> float:
    """Of each number that acts the logarithm of the rows; a track, of which a gain is one, has to show its bend too."""
    track = len(values) > _FEW_TRACK and bool(values[-1])
    return (len(told(context, values)) + (_BEND if track else 0)) * float(np.log(2 * len(context)))


def _parameters(context: Context, site: Site) -> tuple[Parameter, ...]:
    slope, curvature = Parameter(_TRACK[0], (-0.5, 0.5), 0.3), Parameter(_TRACK[1], (-0.5, 0.5), 0.3)
    if _few_angles(context, site):
        return (slope, curvature)
    return (
        Parameter("sine_rad", (-0.2, 0.2), 0.03),
        Parameter("cosine_rad", (-0.2, 0.2), 0.03),
        Parameter("cycles_per_turn", (0.5, 60.0), 3.0, off=None),
        slope,
        replace(curvature, bounds=(-1.0, 1.0)),
        Parameter(_TRACK[2], (-4.0, 4.0), 1.0),
        Parameter("track", (0.0, 1.0), 1.0, scanned=True),
    )


def _few_angles(context: Context, site: Site) -> bool:
    assert site.joint is not None
    return len(np.unique(context.q_cmd[:, site.joint - 1])) < _FEW_ANGLES


def _supported_cycles(context: Context, site: Site) -> list[float]:
    """Return the frequencies that the angles of the joint lie near enough together to tell: four to a cycle."""
    assert site.joint is not None
    gaps = np.diff(np.unique(context.q_cmd[:, site.joint - 1]))
    most = 2.0 * np.pi / (4.0 * float(np.quantile(gaps, 0.75)))
    return [cycles for cycles in _CYCLES if cycles <= max(most, _CYCLES[0])]


def _starts(context: Context, site: Site, around: Array | None) -> Iterable[Array]:
    if around is not None:
        return []
    if _few_angles(context, site):
        return [np.zeros(_FEW_TRACK)]
    harmonics = [[0.0, 0.0, cycles, 0.0, 0.0, 0.0, 0.0] for cycles in _supported_cycles(context, site)]
    return [np.array(values) for values in (*harmonics, [0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0])]


# --- how the simulated bench makes it ---


def inject(world: World, parameters: Mapping[str, Any], site: Site) -> World:
    """Drive the link of `joint`, beyond its potentiometer, by a gear that is bored off its centre.

    The gear turns `cycles_per_turn` times a turn of the joint; its eccentricity makes a peak error of about
    `amplitude_rad`, and `phase_rad` is the gear's angle at joint angle zero. To first order the joint stands at
    q_cmd + amplitude sin(cycles q + phase); an eccentric also makes overtones of it. Raises `InputError` where the bore
    would lie outside the gear.
    """
    index = joint_index(world, site)
    if any(name in parameters for name in _TRACK):
        return _with_track(world, index, [float(parameters.get(name, 0.0)) for name in _TRACK])
    for name in ("amplitude_rad", "cycles_per_turn"):
        if name not in parameters:
            raise InputError(
                f"servo_nonlinearity: key '{name}' is missing, or else slope, curvature_per_rad ... of a track"
            )
    cycles, phase = float(parameters["cycles_per_turn"]), float(parameters["phase_rad"])
    eccentricity = cycles * float(parameters["amplitude_rad"])  # of the bore, in radii of the gear
    if eccentricity > _MOST_ECCENTRIC * (1.0 + 1e-9):
        raise InputError(
            f"servo_nonlinearity: no gear of {cycles:g} cycles_per_turn makes an error of amplitude_rad "
            f"{parameters['amplitude_rad']:g}; at most {_MOST_ECCENTRIC / cycles:.3g}"
        )

    def gear() -> Electronics:
        def receive(command: Command) -> NDArray[np.float64]:
            q = command.q.copy()
            turn = cycles * q[index] + phase
            # Angle of a point of the rim, seen from the bore, less its angle about the gear's centre.
            ahead = math.atan2(eccentricity * math.sin(turn), 1.0 - eccentricity * math.cos(turn))
            q[index] += ahead / cycles
            return q

        return receive

    return world.with_electronics(gear)


def _with_track(world: World, index: int, derivatives: list[float]) -> World:
    """Wind a potentiometer unevenly: the board turns until the wiper's voltage matches the pulse.

    A stretch of the track that has less resistance than its share makes the servo turn farther for the same voltage.
    """
    scale = np.linspace(-world.servo.travel_rad, world.servo.travel_rad, _PIECES)
    middles = 0.5 * (scale[1:] + scale[:-1])
    turned_per_volt = 1.0 + sum(d * middles**k / math.factorial(k) for k, d in enumerate(derivatives))
    turned_per_volt = np.clip(turned_per_volt, *_WINDING)
    angle = np.concatenate([[0.0], np.cumsum(turned_per_volt * np.diff(scale))])
    angle -= np.interp(0.0, scale, angle)

    def board() -> Electronics:
        def receive(command: Command) -> NDArray[np.float64]:
            q = command.q.copy()
            q[index] = np.interp(q[index], scale, angle)
            return q

        return receive

    return world.with_electronics(board)


def _hide(rng: Generator, s: sealed.Situation) -> sealed.Hidden:
    """Draw how it is hidden in a sealed world."""
    cycles, phase = float(rng.uniform(2.0, 12.0)), float(rng.uniform(-np.pi, np.pi))

    def parameters(a: float) -> dict[str, Any]:
        return {"amplitude_rad": a, "cycles_per_turn": cycles, "phase_rad": phase}

    # A gear bored off by more than a fifth of its radius would not mesh.
    return sealed.Hidden(parameters, 0.005, 0.2 / cycles, sealed.any_joint(rng, s))


EFFECT = Effect(
    name="servo_nonlinearity",
    summary="a smooth or periodic error over a joint's angle",
    where="joint",
    stage=Stage.SERVO,
    parameters=_parameters,
    term=term,
    starts=_starts,
    injector=inject,
    injected=(
        Injected("amplitude_rad", (0.0, 0.5), optional=True),
        Injected("cycles_per_turn", (0.1, 200.0), optional=True),
        Injected("phase_rad", (-2.0 * math.pi, 2.0 * math.pi), 0.0, period=2.0 * math.pi),
        Injected("slope", (-0.9, 0.9), optional=True),
        Injected("curvature_per_rad", (-2.0, 2.0), optional=True),
        Injected("third_per_rad2", (-10.0, 10.0), optional=True),
    ),
    confused_with=("servo_gain", "quantization", "gravity_sag"),
    experiment="this joint swept over its whole range in fine steps",
    plans=("full_sweep", "fine_ramp"),
    physical=physical,
    complexity=complexity,
    told=told,
    sealed=sealed.Sealing(_hide),
)


def inject_in_motion(world: MotionWorld, parameters: Mapping[str, Any], site: Site) -> MotionWorld:
    """Drive `joint` by an uneven potentiometer and by a gear that is bored off its centre.

    The track turns the servo by 1 + `slope` + `curvature_per_rad` q + `third_order_per_rad2` q^2 for each unit of its
    scale. The gear errs by about `amplitude_rad` sin(`cycles_per_turn` q + `phase_rad`), as in `inject`, or by as much
    as `sine_rad` sin + `cosine_rad` cos.
    """
    (index,) = world.joints_at(site)
    sine, cosine = (float(parameters[name]) for name in ("sine_rad", "cosine_rad"))
    amplitude, phase = float(parameters["amplitude_rad"]), float(parameters["phase_rad"])
    if sine or cosine:
        amplitude, phase = math.hypot(sine, cosine), math.atan2(cosine, sine)
    cycles = float(parameters["cycles_per_turn"])
    eccentricity = min(cycles * amplitude, _MOST_ECCENTRIC)
    scale = np.linspace(-world.servo.travel_rad, world.servo.travel_rad, _PIECES)
    middle = 0.5 * (scale[1:] + scale[:-1])
    slope, curvature, third = (float(parameters[n]) for n in ("slope", "curvature_per_rad", "third_order_per_rad2"))
    # A third-order error q^3 has three times the slope of one q^2, and a second-order one q^2 / 2 the slope q.
    per_volt = 1.0 + slope + curvature * middle + third * middle**2
    if (per_volt <= 0).any():
        raise InputError("servo_nonlinearity: no track turns back; its terms are too large together")
    angle = np.concatenate([[0.0], np.cumsum(per_volt * np.diff(scale))])
    angle -= np.interp(0.0, scale, angle)

    def turned(q: Array) -> Array:
        out = np.interp(q, scale, angle) if slope or curvature or third else q
        if not amplitude:
            return out
        turn = cycles * out + phase
        ahead = np.arctan2(eccentricity * np.sin(turn), 1.0 - eccentricity * np.cos(turn))
        return out + ahead / cycles

    return world.with_values(index, turned)


IN_MOTION = MotionEffect(
    name=EFFECT.name,
    summary=EFFECT.summary,
    where="joint",
    forms=(
        (
            Slot("curvature_per_rad", "bend", (-0.25, 0.25), (0.0,), 0.005, factor=2.0),
            Slot("third_order_per_rad2", "twist", (-0.2, 0.2), (0.0,), 0.005, factor=3.0),
        ),
        (
            Slot("sine_rad", "ripple_sin_rad", (-0.1, 0.1), (0.0,), 0.002),
            Slot("cosine_rad", "ripple_cos_rad", (-0.1, 0.1), (0.0,), 0.002),
            Slot(
                "cycles_per_turn",
                "ripple_per_turn",
                (0.5, 100.0),
                (1.0, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0, 16.0, 24.0, 36.0),
                0.02,
            ),
        ),
    ),
    confused_with=EFFECT.confused_with,
    experiment=EFFECT.experiment,
    motions=("holds",),
    injector=inject_in_motion,
    injected=(
        Injected("slope", (-0.9, 0.9), 0.0),
        Injected("curvature_per_rad", (-0.5, 0.5), 0.0),
        Injected("third_order_per_rad2", (-0.5, 0.5), 0.0),
        Injected("amplitude_rad", (0.0, 0.5), 0.0),
        Injected("phase_rad", (-2.0 * math.pi, 2.0 * math.pi), 0.0),
        Injected("sine_rad", (-0.5, 0.5), 0.0),
        Injected("cosine_rad", (-0.5, 0.5), 0.0),
        Injected("cycles_per_turn", (0.1, 200.0), 1.0),
    ),
)
