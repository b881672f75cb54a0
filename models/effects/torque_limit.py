"""The servo gives no more than a torque: it slows, or stops, under load.

Known forms: a DC motor's falling line from no-load speed to stall torque (its data sheet); a current limit in the
driver.
Covered: the falling line, against the load of gravity. Not covered: loads of acceleration, and a hard current limit
without the line, which looks like the line near its end.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from armtwin.models.catalogue.injection import Injected
from armtwin.models.catalogue.motion_effect import MotionEffect, Slot
from armtwin.models.catalogue.site import Site
from armtwin.models.motion_world import MotionWorld


def inject_in_motion(world: MotionWorld, parameters: Mapping[str, Any], site: Site) -> MotionWorld:
    """Give the joint a motor that stalls at `torque_nm`: a load takes its share of the speed."""
    (index,) = world.joints_at(site)
    return world.with_drive(index, torque_nm=float(parameters["torque_nm"]))


IN_MOTION = MotionEffect(
    name="torque_limit",
    summary="the servo gives no more than a torque: it slows or stops under load",
    where="joint",
    forms=((Slot("torque_nm", "torque_nm", (0.001, 100.0), (), 0.05),),),
    confused_with=("speed_limit", "gravity_sag", "contact"),
    experiment="fast moves against gravity and with it, arm stretched and folded",
    motions=("steps", "holds"),
    needs_load=True,
    injector=inject_in_motion,
    injected=(Injected("torque_nm", (0.001, 1000.0)),),
)
