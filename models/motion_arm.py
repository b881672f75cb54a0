"""The arm that moves, as a MuJoCo model without motors: planar by its link lengths, or any arm by an MJCF or URDF file.

What turns the joints is the drive, which the simulation adds; here the named joints turn freely and carry no friction,
damping or armature of their own. Gravity is carried for all drawn bodies (`gravcomp`), because the nominal servo holds
without droop; `qfrc_gravcomp` then tells the load of each joint.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np

from armtwin.models.arm import Arm
from armtwin.models.errors import InputError, nearest
from armtwin.models.kinematics import Deviation
from armtwin.models.mjcf import build_arm
from armtwin.models.motion.model_file import bare_model, compiled, read_model
from armtwin.models.servo import nominal_servo

_IGNORED = int(mujoco.mjtDisableBit.mjDSBL_CONTACT)


@dataclass(frozen=True, eq=False)
class MotionArm:
    """An arm of n hinges.

    Attributes:
        name: what people call it.
        joints: (n,) names of the hinges in the model, base first.
        tip: body at which a payload hangs.
        build: returns a fresh model of the arm, its hinges free.

    """

    name: str
    joints: tuple[str, ...]
    tip: str
    build: Callable[[], mujoco.MjSpec]

    @property
    def n_joints(self) -> int:
        """Number of joints."""
        return len(self.joints)

    @property
    def known_markers(self) -> tuple[str, ...]:
        """No markers are followed on an arm in motion by this model."""
        return ()


def planar_arm(arm: Arm, deviation: Deviation | None = None) -> MotionArm:
    """Return the planar arm of `arm`'s link lengths and masses."""

    def build() -> mujoco.MjSpec:
        return _freed(build_arm(arm, nominal_servo(), deviation), names)

    names = tuple(f"joint{i + 1}" for i in range(arm.n_joints))
    return MotionArm(arm.name, names, f"end{arm.n_joints}", build)


def model_arm(name: str, path: Path, joints: tuple[str, ...]) -> MotionArm:
    """Return the arm of an MJCF or URDF file; raises `InputError` where it does not load or lacks a joint.

    Joints that are not named stand still where the model has them.
    """
    return arm_of_text(name, read_model(path), path.name, joints)


def arm_of_text(name: str, text: str, file: str, joints: tuple[str, ...]) -> MotionArm:
    """Return the arm of an MJCF or URDF text, as `model_arm` does; messages name `file`."""
    bare = bare_model(text, file)

    def build() -> mujoco.MjSpec:
        return _freed(compiled(bare, file), joints)

    known = [joint.name for joint in compiled(bare, file).joints]
    for joint in joints:
        if joint not in known:
            raise InputError(f"{file}: has no joint '{joint}'{nearest(joint, known)}")
    return MotionArm(name, joints, _body_of(build(), joints[-1]), build)


def _body_of(spec: mujoco.MjSpec, joint: str) -> str:
    return str(spec.joint(joint).parent.name)


def _freed(spec: mujoco.MjSpec, names: tuple[str, ...]) -> mujoco.MjSpec:
    """Take away all that drives, brakes or stops the hinges, and weld the other joints."""
    for actuator in list(spec.actuators):
        spec.delete(actuator)
    for key in list(spec.keys):
        spec.delete(key)
    for joint in list(spec.joints):
        if joint.name not in names:
            spec.delete(joint)
            continue
        if joint.type != mujoco.mjtJoint.mjJNT_HINGE:
            raise InputError(f"joint '{joint.name}' is no hinge; an arm of turning joints is wanted")
        joint.armature = joint.frictionloss = joint.ref = joint.margin = 0.0
        joint.damping = np.zeros_like(joint.damping)
        joint.stiffness = np.zeros_like(joint.stiffness)
        joint.limited = int(mujoco.mjtLimited.mjLIMITED_FALSE)
    for body in spec.bodies[1:]:
        body.gravcomp = 1.0
    spec.option.disableflags = int(spec.option.disableflags) | _IGNORED
    return spec
