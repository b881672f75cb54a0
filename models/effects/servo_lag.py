"""The servo's loop follows more slowly than the twin's.

Known forms: a first-order approach with a longer time constant (a proportional loop on a geared motor whose speed the
back-EMF sets; viscous friction adds to it, and one recording cannot tell which); a second-order one with the inertia
beside it (`inertia`).
Covered: one time constant a joint. Not covered: a time constant that differs with the direction.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from armtwin.models.catalogue.injection import Injected
from armtwin.models.catalogue.motion_effect import MotionEffect, Slot
from armtwin.models.catalogue.site import Site
from armtwin.models.motion_world import MotionWorld


def inject_in_motion(world: MotionWorld, parameters: Mapping[str, Any], site: Site) -> MotionWorld:
    """Lower the gain of the loop: the motor closes its error with `time_constant_s` instead."""
    (index,) = world.joints_at(site)
    return world.with_drive(index, time_constant_s=float(parameters["time_constant_s"]))


IN_MOTION = MotionEffect(
    name="servo_lag",
    summary="the servo's loop follows more slowly than the twin's",
    where="joint",
    forms=((Slot("time_constant_s", "time_constant_s", (0.002, 1.0), (0.03, 0.06, 0.12), 0.005),),),
    confused_with=("latency", "friction", "speed_limit"),
    experiment="steps of several sizes between holds: the lag is the same share of each",
    motions=("steps", "chirp"),
    injector=inject_in_motion,
    injected=(Injected("time_constant_s", (0.001, 10.0)),),
)
