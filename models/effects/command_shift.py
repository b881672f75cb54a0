"""Pictures paired with the wrong command, off by a constant number of rows.

Known forms: a first picture that was dropped or taken twice, a log that writes the next command beside the picture, a
camera's queue that is one frame behind. Covered: the same shift for all rows, a whole number. Not covered: a shift
that begins within the recording or differs between joints.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from armtwin.models.catalogue import sealed
from armtwin.models.catalogue.context import Context
from armtwin.models.catalogue.injection import Injected
from armtwin.models.catalogue.registry import Effect, Parameter, Site, Stage
from armtwin.models.world import World

Array = NDArray[np.float64]


_FARTHEST_ROWS = 6


def term(context: Context, q: Array, values: Array, site: Site) -> Array:
    """Commands of `rows` poses earlier (later where negative)."""
    source = np.clip(np.arange(len(q)) - round(float(values[0])), 0, len(q) - 1)
    return q[source]


def _parameters(context: Context, site: Site) -> tuple[Parameter, ...]:
    return (Parameter("rows", (-float(_FARTHEST_ROWS), float(_FARTHEST_ROWS)), 3.0, scanned=True),)


def _starts(context: Context, site: Site, around: Array | None) -> Iterable[Array]:
    if around is not None:
        return []
    return [np.array([float(rows)]) for rows in range(-_FARTHEST_ROWS, _FARTHEST_ROWS + 1) if rows]


# --- how the simulated bench makes it ---


def inject(world: World, parameters: Mapping[str, Any], site: Site) -> World:
    """Let the camera's buffer hand out stale pictures: row i is filed with the picture of pose i - `rows`.

    Negative rows file later pictures. At the ends, where there is no such pose, the nearest one is filed.
    """
    return replace(world, picture_lag=world.picture_lag + int(parameters["rows"]))


def _hide(rng: Generator, s: sealed.Situation) -> sealed.Hidden:
    """Draw how it is hidden in a sealed world."""
    rows = int(sealed.sign(rng) * rng.integers(1, 4))
    return sealed.Hidden(lambda a: {"rows": rows}, 1.0, 1.0)


EFFECT = Effect(
    name="command_shift",
    summary="pictures paired with the wrong command",
    where="arm",
    stage=Stage.COMMAND,
    parameters=_parameters,
    term=term,
    starts=_starts,
    injector=inject,
    injected=(Injected("rows", (-100.0, 100.0), kind="whole"),),
    confused_with=("settling_lag",),
    experiment="single large steps between rests: which picture shows the step",
    plans=("growing_steps",),
    needs_return=True,
    sealed=sealed.Sealing(_hide),
)
