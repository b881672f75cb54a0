"""Dry friction in a servo's gear and bearing, beyond the twin's.

A proportional loop stands still while its error is below the friction over its stiffness: a band about the command,
which an encoder on the motor's side shows like play. Known forms: Coulomb's constant friction; viscous friction,
which is one with a slower loop (`servo_lag`); Stribeck's, which is larger at standstill (B. Armstrong-Hélouvry and
others, Automatica 30, 1994); friction that grows with the torque through the gear, its own or the load's (the ladder
M1 to M6 of Rhoban's BAM, M. Duclusaud and others, "Extended friction models for the physics simulation of servo
actuators", 2024).
Covered: all of these, each offered where the recording asks for it. Not covered: friction that differs with the
direction or over the turn, and with temperature.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from armtwin.models.catalogue.injection import Injected
from armtwin.models.catalogue.motion_effect import MotionEffect, Slot
from armtwin.models.catalogue.site import Site
from armtwin.models.motion_world import MotionWorld

_COULOMB = Slot("coulomb_rad", "coulomb_rad", (0.0, 0.3), (0.003, 0.012, 0.04), 0.002)
_STRIBECK = (
    Slot("stribeck_rad", "stribeck_rad", (0.0, 0.3), (0.006,), 0.002),
    Slot("stribeck_speed_rad_s", "stribeck_speed_rad_s", (0.005, 3.0), (0.05, 0.3), 0.02),
)
_SHARES = (
    Slot("load_share", "load_share", (0.0, 0.95), (0.05, 0.3), 0.02),
    Slot("drive_share", "drive_share", (0.0, 0.95), (0.05, 0.3), 0.02),
)


def inject_in_motion(world: MotionWorld, parameters: Mapping[str, Any], site: Site) -> MotionWorld:
    """Let the joint rub dry by MuJoCo's `frictionloss`, of a size that follows speed and torques, and viscously."""
    (index,) = world.joints_at(site)
    names = [one.name for one in IN_MOTION.injected if one.name in parameters]
    return world.with_drive(index, **{name: float(parameters[name]) for name in names})


IN_MOTION = MotionEffect(
    name="friction",
    summary="dry friction beyond the twin's: the servo stands still while its error is small",
    where="joint",
    forms=((_COULOMB,), (_COULOMB, *_STRIBECK), (_COULOMB, _SHARES[0]), (_COULOMB, *_STRIBECK, _SHARES[0])),
    further=(
        _STRIBECK,
        (_SHARES[0],),
        (_SHARES[1],),
        (Slot("stribeck_drive_share", "stribeck_drive_share", (0.0, 2.0), (0.05, 0.3), 0.02),),
        (Slot("stribeck_load_share", "stribeck_load_share", (0.0, 2.0), (0.05, 0.3), 0.02),),
    ),
    confused_with=("backlash", "dead_band", "hysteresis"),
    experiment="slow reversals under another load or P gain: friction's band follows them, play's does not",
    motions=("reversals", "holds"),
    injector=inject_in_motion,
    injected=(
        Injected("coulomb_rad", (0.0, 1.0), 0.0),
        Injected("stribeck_rad", (0.0, 1.0), 0.0),
        Injected("stribeck_speed_rad_s", (1e-4, 100.0), 0.1),
        Injected("load_share", (0.0, 1.0), 0.0),
        Injected("drive_share", (0.0, 0.95), 0.0),
        Injected("stribeck_load_share", (0.0, 10.0), 0.0),
        Injected("stribeck_drive_share", (0.0, 10.0), 0.0),
        Injected("viscous_s", (0.0, 10.0), 0.0),
    ),
)
