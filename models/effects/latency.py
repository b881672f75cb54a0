"""A command acts, or is seen to act, later by a fixed time.

Known forms: the serial bus's or the host's queue; the servo's own frame (a hobby servo hears its pulse once in 20 ms:
0 to 20 ms, 10 on average); the controller's cycle; a reading that is older than its time stamp. One recording cannot
tell a late command from a late clock.
Covered: one delay a joint, or one of the whole arm. Not covered: a delay that jitters from command to command, of
which the mean is found.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from armtwin.models.catalogue.injection import Injected
from armtwin.models.catalogue.motion_effect import MotionEffect, Slot
from armtwin.models.catalogue.site import Site
from armtwin.models.motion_world import MotionWorld, Wire


def inject_in_motion(world: MotionWorld, parameters: Mapping[str, Any], site: Site) -> MotionWorld:
    """Put a delay line into the wire of a joint."""
    (index,) = world.joints_at(site)
    delay = float(parameters["delay_s"])

    def line(wires: Sequence[Wire]) -> list[Wire]:
        out = list(wires)
        out[index] = replace(out[index], time_s=out[index].time_s + delay)
        return out

    return world.with_wiring(line)


IN_MOTION = MotionEffect(
    name="latency",
    summary="a command acts, or is seen to act, later by a fixed time",
    where="joint",
    forms=((Slot("delay_s", "delay_s", (0.0, 0.5), (0.01, 0.03, 0.06), 0.005),),),
    confused_with=("servo_lag", "sampling", "inertia"),
    experiment="steps between long holds: a delay shifts the answer, a lag rounds it",
    motions=("steps", "chirp"),
    injector=inject_in_motion,
    injected=(Injected("delay_s", (0.0, 5.0)),),
)
