"""The arm of a moving world as a MuJoCo model: the arm, a drive at every joint, and what the mechanisms add."""

from __future__ import annotations

import mujoco

from armtwin.models.mjcf import building
from armtwin.models.motion_world import HARD_SOLIMP, HARD_SOLREF, MotionWorld
from armtwin.sim.motion.drive import STIFFNESS_NM_RAD

LONGEST_STEP_S = 0.001
# Dry friction of MuJoCo creeps: by 0.1 mrad/s where half of it would hold. So much of that is left.
_CREEP = 0.01


def motion_spec(world: MotionWorld, friction: bool) -> mujoco.MjSpec:
    """Return the model for steps of up to 1 ms, whose drives get their numbers at every step (`DriveBank`)."""
    spec = world.arm.build()
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_EULER
    spec.option.disableflags = int(spec.option.disableflags) | int(mujoco.mjtDisableBit.mjDSBL_EULERDAMP)
    spec.option.timestep = LONGEST_STEP_S
    for name in world.arm.joints:
        joint = spec.joint(name)
        joint.armature = STIFFNESS_NM_RAD * world.servo.loop_time_s * LONGEST_STEP_S
        if friction:
            joint.frictionloss = 1.0  # so that it has a place in the model; its size is set at every step
            joint.solref_friction = HARD_SOLREF
            joint.solimp_friction = HARD_SOLIMP
        actuator = spec.add_actuator(
            name=drive_name(name), target=name, trntype=mujoco.mjtTrn.mjTRN_JOINT, forcelimited=True, forcerange=[-1, 1]
        )
        actuator.set_to_position(kp=STIFFNESS_NM_RAD)
    for mechanism in world.mechanics:
        mechanism(spec, STIFFNESS_NM_RAD)
    return spec


def compiled(world: MotionWorld, friction: bool) -> mujoco.MjModel:
    """Compile it."""
    with building():
        model = motion_spec(world, friction).compile()
    model.dof_invweight0[:] *= _CREEP  # by which MuJoCo judges how soft a constraint may be
    return model


def drive_name(joint: str) -> str:
    """Return the name of a joint's actuator."""
    return f"drive_{joint}"
