"""Single poses at which the arm stayed where it was.

A pose was missed where all that is seen agrees with the pose before it and nothing with its own.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from armtwin.models.catalogue.context import Context
from armtwin.models.catalogue.injection import samples
from armtwin.models.catalogue.registry import Effect, Parameter, Site, Stage, View
from armtwin.models.world import Command, Electronics, World, samples_of

Array = NDArray[np.float64]

# What is seen must miss its own pose by this many standard deviations, and meet the one before within the other.
_MISSES = 8.0
_MEETS = 4.0


def term(context: Context, q: Array, values: Array, site: Site) -> Array:
    """Commands of which those at the rows `values` never reached the arm."""
    out = q.copy()
    for row in values.astype(int):
        out[row] = out[row - 1]
    return out


def find(context: Context, view: View) -> list[tuple[Site, Array]]:
    """Return the rows that agree with the last executed pose and not with their own."""
    rows: list[int] = []
    last = 0
    for row in range(1, len(view.observed)):
        own = view.misfit(view.observed[row], view.predicted[row])
        before = view.misfit(view.observed[row], view.predicted[last])
        # A marker that both poses put in the same place says nothing.
        telling = np.isfinite(own) & (view.misfit(view.predicted[row], view.predicted[last]) > _MISSES)
        # Of those that do tell, one that plainly misses its own pose is enough: the others meet the one before.
        if telling.any() and own[telling].max() > _MISSES and before[telling].max() < _MEETS:
            rows.append(row)
        else:
            last = row
    return [(Site(), np.array(rows, dtype=float))] if rows else []


def physical(context: Context, values: Array) -> dict[str, Any]:
    """Return the missed rows as the simulated bench takes them."""
    return {"samples": values.astype(int).tolist()}


def _parameters(context: Context, site: Site) -> tuple[Parameter, ...]:
    return ()


def _starts(context: Context, site: Site, around: Array | None) -> Iterable[Array]:
    return []


# --- how the simulated bench makes it ---


def inject(world: World, parameters: Mapping[str, Any], joint: int | None = None, marker: str | None = None) -> World:
    """Lose the commands of `samples` on the wire: the servos hold the last one that arrived."""
    lost = frozenset(samples_of(parameters))

    def wire() -> Electronics:
        arrived = np.zeros(world.arm.n_joints)

        def receive(command: Command) -> NDArray[np.float64]:
            nonlocal arrived
            if command.sample not in lost:
                arrived = command.q
            return arrived

        return receive

    return world.with_electronics(wire)


EFFECT = Effect(
    name="missed_command",
    summary="single poses at which the arm stayed where it was",
    where="arm",
    stage=Stage.COMMAND,
    parameters=_parameters,
    term=term,
    starts=_starts,
    injector=inject,
    injected=(samples("samples"),),
    confused_with=("outliers", "dead_band"),
    experiment="the missed poses commanded once more",
    plans=("growing_steps",),
    physical=physical,
    find=find,
    needs_return=True,
)
