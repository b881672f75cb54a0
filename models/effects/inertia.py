"""More inertia at a joint than the model has.

Known forms: the rotor behind its gear (its inertia times the ratio squared; armature in MuJoCo's words); an
undeclared part. The loop then answers in second order, with an overshoot where it is strong.
Covered: one inertia a joint, by the loop's stiffness. Not covered: inertia that changes with the pose.
"""

from __future__ import annotations

from armtwin.models.catalogue.motion_effect import MotionEffect, Slot

IN_MOTION = MotionEffect(
    name="inertia",
    summary="more inertia at a joint than the model has",
    where="joint",
    forms=((Slot("armature_kg_m2", "inertia_s2", (0.0, 20.0), (0.01, 0.1, 0.4), 0.01),),),
    confused_with=("servo_lag", "latency"),
    experiment="chirps and steps: an overshoot, and a phase that falls beyond a quarter turn",
)
