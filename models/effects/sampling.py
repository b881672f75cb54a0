"""Commands or readings held, repeated, dropped or delayed from a moment on by the bus or the host: all joints alike.

Known forms: a queue that fills, so that from a moment on all commands act later; a bus that answers every second
request, so that readings repeat; a host that skips cycles, so that commands stay in force for several rows.
Covered: later from a moment on; readings or commands held for some rows from a moment on. Not covered: single cycles
that are lost at random, which show as noise.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from armtwin.models.catalogue.injection import Injected, switch
from armtwin.models.catalogue.motion_effect import MotionEffect
from armtwin.models.catalogue.site import Site
from armtwin.models.motion_world import MotionWorld, Wire

Array = NDArray[np.float64]


def inject_in_motion(world: MotionWorld, parameters: Mapping[str, Any], site: Site) -> MotionWorld:
    """Let the host fall behind at `from_s`: from then on commands reach all drives `delay_s` later.

    With `held_rows` the bus answers only every so many rows, and the reading before is repeated; with `of_commands` 1
    only every so many commands are sent.
    """
    start, delay = float(parameters["from_s"]), float(parameters["delay_s"])
    held, of_commands = int(parameters["held_rows"]), bool(parameters["of_commands"])

    def host(wires: Sequence[Wire]) -> list[Wire]:
        out = []
        for wire in wires:
            late = wire.time_s >= start
            first = int(np.argmax(late)) if late.any() else len(late)
            sent = np.ones(len(late), dtype=bool)
            if of_commands:
                sent = ~late | ((np.arange(len(late)) - first) % held == 0)
            out.append(Wire((wire.time_s + np.where(late, delay, 0.0))[sent], wire.q[sent], wire.row[sent]))
        return out

    def bus(time_s: Array, q: Array, rng: Generator) -> Array:
        rows, first = np.arange(len(time_s)), int(np.searchsorted(time_s, start))
        answered = np.where(rows >= first, rows - (rows - first) % held, rows)
        return q[answered]

    world = world.with_wiring(host)
    return world if of_commands or held == 1 else world.with_reading(bus)


IN_MOTION = MotionEffect(
    name="sampling",
    summary="from a moment on commands or readings are late, held or dropped: all joints alike",
    where="arm",
    confused_with=("latency",),
    experiment="the same motion again, the host doing nothing else: what falls behind does it elsewhere",
    motions=("chirp", "steps"),
    injector=inject_in_motion,
    injected=(
        Injected("from_s", (-1e18, 1e18)),
        Injected("delay_s", (0.0, 100.0), 0.0),
        Injected("held_rows", (1, 1000), 1, kind="whole"),
        switch("of_commands", 0),
    ),
)
