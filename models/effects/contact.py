"""Something in the way stops the arm short of its command.

Known forms: a joint's own end stop; the table, another link or a cable under the arm, which stops a joint only in
some poses of the others.
Covered: a stop at one angle of a joint, for one direction. Partly: what stops the arm in some stretches only: their
times are told and their samples are left out of the fit. Not covered: a stop that gives way.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import mujoco

from armtwin.models.catalogue.injection import Injected
from armtwin.models.catalogue.motion_effect import MotionEffect, Slot
from armtwin.models.catalogue.site import Site
from armtwin.models.errors import InputError
from armtwin.models.motion_world import HARD_SOLIMP, HARD_SOLREF, MotionWorld

# No joint turns so far.
_FREE_RAD = 100.0


def inject_in_motion(world: MotionWorld, parameters: Mapping[str, Any], site: Site) -> MotionWorld:
    """Put a hard stop in the way of a joint at `stop_rad`: of growing angles (`side` 1) or falling ones (-1)."""
    (index,) = world.joints_at(site)
    stop, side = float(parameters["stop_rad"]), float(parameters["side"])
    if side not in (1.0, -1.0):
        raise InputError(f"contact: side: found {side:g}, 1 (it stops growing angles) or -1 is wanted")

    def mechanism(spec: mujoco.MjSpec, scale: float) -> None:
        joint = spec.joint(world.arm.joints[index])
        low, high = joint.range if joint.limited == mujoco.mjtLimited.mjLIMITED_TRUE else (-_FREE_RAD, _FREE_RAD)
        joint.limited = int(mujoco.mjtLimited.mjLIMITED_TRUE)
        joint.range = [low, min(high, stop)] if side > 0 else [max(low, stop), high]
        joint.solref_limit, joint.solimp_limit = HARD_SOLREF, HARD_SOLIMP

    return world.with_mechanism(mechanism)


IN_MOTION = MotionEffect(
    name="contact",
    summary="something in the way stops the arm short of its command",
    where="joint",
    forms=(
        (Slot("stop_rad", "stop_high_rad", (-3.2, 3.2), (), 0.005),),
        (Slot("stop_rad", "stop_low_rad", (-3.2, 3.2), (), 0.005),),
    ),
    confused_with=("torque_limit", "missed_command", "friction"),
    experiment="the same commands with the way free, or moved away from the stop",
    motions=("holds", "reversals"),
    injector=inject_in_motion,
    injected=(
        Injected("stop_rad", (-7.0, 7.0)),
        Injected("side", (-1.0, 1.0), 1.0),
    ),
)
