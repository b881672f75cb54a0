"""More inertia at a joint than the model has.

Known forms: the rotor behind its gear (its inertia times the ratio squared; armature in MuJoCo's words); an
undeclared part. The loop then answers in second order, with an overshoot where it is strong.
Covered: one inertia a joint, by the loop's stiffness. Not covered: inertia that changes with the pose.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from armtwin.models.catalogue.injection import Injected
from armtwin.models.catalogue.motion_effect import MotionEffect, Slot
from armtwin.models.catalogue.site import Site
from armtwin.models.motion_world import MotionWorld


def inject_in_motion(world: MotionWorld, parameters: Mapping[str, Any], site: Site) -> MotionWorld:
    """Put a heavier rotor behind the gear: MuJoCo's armature."""
    (index,) = world.joints_at(site)
    armature = world.drives[index].armature_kg_m2 + float(parameters["armature_kg_m2"])
    return world.with_drive(index, armature_kg_m2=armature)


# The nominal servo's (models/nominal/servo.toml): angles alone tell the inertia over the loop's stiffness.
_STIFFNESS_NM_RAD = 50.0

IN_MOTION = MotionEffect(
    name="inertia",
    summary="more inertia at a joint than the model has",
    where="joint",
    forms=(
        (Slot("armature_kg_m2", "inertia_s2", (0.0, 0.05), (0.0002, 0.001, 0.004), 0.0002, factor=_STIFFNESS_NM_RAD),),
    ),
    confused_with=("servo_lag", "latency"),
    experiment="chirps and steps: an overshoot, and a phase that falls beyond a quarter turn",
    motions=("chirp", "steps"),
    injector=inject_in_motion,
    injected=(Injected("armature_kg_m2", (0.0, 1000.0)),),
)
