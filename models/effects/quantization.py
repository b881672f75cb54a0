"""Commands land on coarse steps: whole degrees, or few bits."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from armtwin.models.catalogue.context import Context
from armtwin.models.catalogue.injection import Injected
from armtwin.models.catalogue.registry import Effect, Evidence, Parameter, Site, Stage
from armtwin.models.catalogue.scan import fan_about
from armtwin.models.world import Command, Electronics, World

Array = NDArray[np.float64]


# Steps met in practice: whole and tenth degrees, and 4 to 10 bits over half a turn or a whole one.
_USUAL_STEPS = tuple(np.radians([0.5, 1.0, 2.0, 3.0, 4.0, 5.0])) + tuple(
    turn / count for turn in (np.pi, 2 * np.pi) for bits in range(5, 11) for count in (2**bits, 2**bits - 1)
)


_LARGEST_STEP = 0.2
_SMALLEST_STEP = 3e-4
_SUGGESTED = 12
# Of a few hundred commands some lie this much nearer to the middle between two steps than a quarter step.
_FINEST = 1000.0
_FAN = 12


def term(context: Context, q: Array, values: Array, site: Site) -> Array:
    """Commands rounded to whole multiples of `step_rad`."""
    step = values[0]
    out: Array = np.round(q / step) * step
    return out


def _parameters(context: Context, site: Site) -> tuple[Parameter, ...]:
    return (Parameter("step_rad", (1e-4, 0.3), 0.02, scanned=True),)


def _starts(context: Context, site: Site, around: Array | None) -> Iterable[Array]:
    if around is not None:
        widest = 0.2 * _tolerance(context)
        return [np.array([step]) for step in fan_about(float(around[0]), widest, widest / _FINEST, _FAN)]
    return [np.array([step]) for step in _USUAL_STEPS]


def _tolerance(context: Context) -> float:
    """Relative error of a step of 0.02 rad at which its grid is off by a quarter step at the largest command."""
    return 0.25 * 0.02 / max(float(np.abs(context.q_cmd).max()), 0.02)


def _screen(context: Context, site: Site, evidence: Evidence) -> Iterable[Array]:
    """Return the steps whose rounding errors the residual of the joint angles resembles most."""
    widest = max(float(np.abs(context.q_cmd).max()), 0.02)
    steps = [_LARGEST_STEP]
    while steps[-1] > _SMALLEST_STEP:
        # The next step shifts the grid by a quarter of itself at the largest command.
        steps.append(steps[-1] / (1.0 + 0.25 * steps[-1] / widest))
    grid = np.array(steps)
    changes = np.concatenate([evidence.change(_errors(evidence.commands, part)) for part in np.array_split(grid, 64)])
    return [np.array([grid[index]]) for index in np.argsort(changes)[:_SUGGESTED]]


def _errors(q: Array, steps: Array) -> Array:
    """(S, N, n) rounding errors of commands (N, n) for (S,) steps."""
    wide = steps[:, None, None]
    out: Array = np.round(q / wide) * wide - q
    return out


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
    injector=inject,
    injected=(Injected("step_rad", (1e-5, 1.6)),),
    screen=_screen,
    confused_with=("dead_band", "servo_nonlinearity"),
    experiment="a fine ramp of each joint over several steps",
    plans=("fine_ramp",),
)
