"""The servo turns no faster than a limit below the drawing's.

Known forms: a supply below its nominal voltage; a limit in the servo's own register; firmware that ramps commands.
Covered: one limit a joint, for both directions. Not covered: one that differs with the direction, and a limited
acceleration.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from armtwin.models.catalogue.injection import Injected
from armtwin.models.catalogue.motion_effect import MotionEffect, Slot
from armtwin.models.catalogue.site import Site
from armtwin.models.motion_world import MotionWorld


def inject_in_motion(world: MotionWorld, parameters: Mapping[str, Any], site: Site) -> MotionWorld:
    """Give the motor less voltage: it turns no faster than `speed_rad_s` without a load."""
    (index,) = world.joints_at(site)
    return world.with_drive(index, speed_rad_s=float(parameters["speed_rad_s"]))


IN_MOTION = MotionEffect(
    name="speed_limit",
    summary="the servo turns no faster than a limit below the drawing's",
    where="joint",
    forms=((Slot("speed_rad_s", "speed_rad_s", (0.02, 6.16), (0.5, 1.5, 3.0), 0.1),),),
    confused_with=("servo_lag", "torque_limit"),
    experiment="steps of several sizes: the time to arrive grows with the size",
    motions=("steps",),
    injector=inject_in_motion,
    injected=(Injected("speed_rad_s", (0.001, 100.0)),),
)
