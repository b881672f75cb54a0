"""Friction-held lag that grows smoothly after a reversal.

The term is Dahl's model of friction without velocity (P. Dahl, "A solid friction model", 1968): after a reversal the
lag approaches its saturated value exponentially over the travelled angle.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from models.effects.context import Context
from models.effects.registry import Effect, Parameter, Site, Stage

Array = NDArray[np.float64]


def term(context: Context, q: Array, values: Array, site: Site) -> Array:
    """Angles that lag behind the drive by up to `lag_rad`, built up over `length_rad` of travel."""
    lag, length, start_side = values
    assert site.joint is not None
    joint = site.joint - 1
    out = q.copy()
    state = start_side * lag
    drive = q[:, joint]
    moves = np.diff(drive, prepend=drive[0]).tolist()
    held = np.empty(len(q))
    for row, move in enumerate(moves):
        if move:
            goal = lag if move > 0 else -lag
            state = goal + (state - goal) * float(np.exp(-abs(move) / length))
        held[row] = state
    out[:, joint] -= held
    return out


def _parameters(context: Context, site: Site) -> tuple[Parameter, ...]:
    return (
        Parameter("lag_rad", (0.0, 0.2), 0.02),
        Parameter("length_rad", (1e-4, 1.0), 0.1, off=0.05),
        Parameter("start_side", (-1.0, 1.0), 1.0, scanned=True),
    )


def _starts(context: Context, site: Site, around: Array | None) -> Iterable[Array]:
    if around is not None:
        return []
    return [np.array([0.005, length, side]) for length in (0.01, 0.03, 0.08, 0.2) for side in (-1.0, 0.0, 1.0)]


# --- how the simulated bench makes it ---


def inject(world: Any, parameters: Mapping[str, Any], joint: int | None = None, marker: str | None = None) -> Any:
    """To be written by the physics engineer."""
    raise NotImplementedError


EFFECT = Effect(
    name="hysteresis",
    summary="friction-held lag that grows smoothly after a reversal",
    where="joint",
    stage=Stage.JOINT,
    parameters=_parameters,
    term=term,
    starts=_starts,
    inject=inject,
    confused_with=("backlash", "settling_lag"),
    experiment="fine steps of this joint round a reversal: play keeps still, then follows one to one; friction bends",
    plans=("reversal",),
)
