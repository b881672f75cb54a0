"""A zero that creeps with time and settles.

The term is a first-order rise. Where no time was recorded, one pose counts as one second.
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
        Parameter("time_constant_s", (0.01 * span, 3.0 * span), span, off=0.3 * span),
    )


def _starts(context: Context, site: Site, around: Array | None) -> Iterable[Array]:
    span = float(context.elapsed_s[-1])
    return [] if around is not None else [np.array([0.0, part * span]) for part in (0.05, 0.12, 0.3, 0.8, 2.0)]


# --- how the simulated bench makes it ---


def inject(world: Any, parameters: Mapping[str, Any], joint: int | None = None, marker: str | None = None) -> Any:
    """To be written by the physics engineer."""
    raise NotImplementedError


EFFECT = Effect(
    name="thermal_drift",
    summary="a zero that creeps with time and settles",
    where="joint",
    stage=Stage.JOINT,
    parameters=_parameters,
    term=term,
    starts=_starts,
    inject=inject,
    confused_with=("camera_drift", "joint_slip"),
    experiment="one pose repeated now and then over a long time",
    plans=("repeat_pose",),
)
