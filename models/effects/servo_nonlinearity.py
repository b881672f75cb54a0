"""A smooth or periodic error over a joint's angle.

The term is one harmonic of the commanded angle with free frequency; low frequencies stand for smooth errors.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from armtwin.models.catalogue.context import Context
from armtwin.models.catalogue.injection import Injected
from armtwin.models.catalogue.registry import Effect, Parameter, Site, Stage
from armtwin.models.errors import InputError
from armtwin.models.world import Command, Electronics, World, joint_index

Array = NDArray[np.float64]


# A gear whose bore lies nearer to its rim than this part of its radius does not hold together.
_MOST_ECCENTRIC = 0.95
# Errors of less than one cycle over the range of a hobby servo are smooth; gears repeat up to some thirty times.
_CYCLES = (1.0, 2.0, 3.0, 4.0, 6.0, 8.0, 10.0, 12.0, 15.0, 18.0, 22.0, 26.0, 30.0, 36.0)


def term(context: Context, q: Array, values: Array, site: Site) -> Array:
    """Angles with an error of sine and cosine of `cycles_per_turn` times the joint's angle."""
    sine, cosine, cycles = values
    assert site.joint is not None
    joint = site.joint - 1
    out = q.copy()
    out[:, joint] += sine * np.sin(cycles * q[:, joint]) + cosine * np.cos(cycles * q[:, joint])
    return out


def physical(context: Context, values: Array) -> dict[str, Any]:
    """Return amplitude, frequency and phase, as the simulated bench takes them: at most what a gear can make."""
    sine, cosine, cycles = values
    return {
        "amplitude_rad": min(float(np.hypot(sine, cosine)), _MOST_ECCENTRIC / float(cycles)),
        "cycles_per_turn": float(cycles),
        "phase_rad": float(np.arctan2(cosine, sine)),
    }


def _parameters(context: Context, site: Site) -> tuple[Parameter, ...]:
    return (
        Parameter("sine_rad", (-0.2, 0.2), 0.03),
        Parameter("cosine_rad", (-0.2, 0.2), 0.03),
        Parameter("cycles_per_turn", (0.5, 60.0), 3.0, off=None),
    )


def _starts(context: Context, site: Site, around: Array | None) -> Iterable[Array]:
    return [] if around is not None else [np.array([0.0, 0.0, cycles]) for cycles in _CYCLES]


# --- how the simulated bench makes it ---


def inject(world: World, parameters: Mapping[str, Any], joint: int | None = None, marker: str | None = None) -> World:
    """Drive the link of `joint`, beyond its potentiometer, by a gear that is bored off its centre.

    The gear turns `cycles_per_turn` times a turn of the joint; its eccentricity makes a peak error of about
    `amplitude_rad`, and `phase_rad` is the gear's angle at joint angle zero. To first order the joint stands at
    q_cmd + amplitude sin(cycles q + phase); an eccentric also makes overtones of it. Raises `InputError` where the bore
    would lie outside the gear.
    """
    index = joint_index(world, joint)
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
        Injected("amplitude_rad", (0.0, 0.5)),
        Injected("cycles_per_turn", (0.1, 200.0)),
        Injected("phase_rad", (-2.0 * math.pi, 2.0 * math.pi), 0.0),
    ),
    confused_with=("servo_gain", "quantization", "gravity_sag"),
    experiment="this joint swept over its whole range in fine steps",
    plans=("full_sweep", "fine_ramp"),
    physical=physical,
)
