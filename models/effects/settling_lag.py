"""The picture was taken before the arm arrived.

The term is a first-order approach: of every step a fraction remains when the picture is taken. Where the waits differ,
the fraction is that of the median wait.
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
    """Angles that lack the fraction `values` (n,) of each step."""
    remaining = np.clip(values, -0.95, 0.99)
    waits = context.relative_waits
    out = np.empty_like(q)
    state = q[0]
    for row in range(len(q)):
        left = np.sign(remaining) * np.abs(remaining) ** waits[row]
        state = q[row] + left * (state - q[row])
        out[row] = state
    return out


def _parameters(context: Context, site: Site) -> tuple[Parameter, ...]:
    return tuple(Parameter(f"remaining{joint + 1}", (-0.5, 0.98), 0.3) for joint in range(context.arm.n_joints))


def _starts(context: Context, site: Site, around: Array | None) -> Iterable[Array]:
    n = context.arm.n_joints
    return [] if around is not None else [np.full(n, fraction) for fraction in (0.05, 0.4)]


# --- how the simulated bench makes it ---


def inject(world: Any, parameters: Mapping[str, Any], joint: int | None = None, marker: str | None = None) -> Any:
    """To be written by the physics engineer."""
    raise NotImplementedError


EFFECT = Effect(
    name="settling_lag",
    summary="the picture was taken before the arm arrived",
    where="arm",
    stage=Stage.JOINT,
    parameters=_parameters,
    term=term,
    starts=_starts,
    inject=inject,
    confused_with=("backlash", "hysteresis", "command_shift"),
    experiment="large and small steps to the same pose, and the same steps with a longer wait",
    plans=("growing_steps",),
)
