"""Commands land on coarse steps: whole degrees, or few bits."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from models.effects.context import Context
from models.effects.registry import Effect, Parameter, Site, Stage
from models.effects.scan import steps_around
from models.world import Command, Electronics, World

Array = NDArray[np.float64]


# Steps met in practice: whole and tenth degrees, and 4 to 10 bits over half a turn or a whole one.
_USUAL_STEPS = tuple(np.radians([0.5, 1.0, 2.0, 3.0, 4.0, 5.0])) + tuple(
    turn / count for turn in (np.pi, 2 * np.pi) for bits in range(5, 11) for count in (2**bits, 2**bits - 1)
)


def term(context: Context, q: Array, values: Array, site: Site) -> Array:
    """Commands rounded to whole multiples of `step_rad`."""
    step = values[0]
    out: Array = np.round(q / step) * step
    return out


def _parameters(context: Context, site: Site) -> tuple[Parameter, ...]:
    return (Parameter("step_rad", (1e-4, 0.3), 0.02, scanned=True),)


def _starts(context: Context, site: Site, around: Array | None) -> Iterable[Array]:
    if around is not None:
        return [np.array([value]) for value in steps_around(float(around[0]), 1.008, 33)]
    # A step that is off by 1 % loses its grid only after some 25 steps, which the arm's range rarely exceeds.
    return [np.array([step]) for step in (*_USUAL_STEPS, *np.geomspace(0.004, 0.2, 320))]


# --- how the simulated bench makes it ---


def inject(world: World, parameters: Mapping[str, Any], joint: int | None = None, marker: str | None = None) -> World:
    """Let the sender write every command as a whole number of `step_rad`."""
    step = float(parameters["step_rad"])

    def sender() -> Electronics:
        def receive(command: Command) -> NDArray[np.float64]:
            counts = np.round(command.q / step)
            written: NDArray[np.float64] = counts * step
            return written

        return receive

    return world.with_electronics(sender)


EFFECT = Effect(
    name="quantization",
    summary="commands land on coarse steps (whole degrees, few bits)",
    where="arm",
    stage=Stage.COMMAND,
    parameters=_parameters,
    term=term,
    starts=_starts,
    inject=inject,
    confused_with=("dead_band", "servo_nonlinearity"),
    experiment="a fine ramp of each joint over several steps",
    plans=("fine_ramp",),
)
