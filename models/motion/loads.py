"""The torques that gravity puts on the joints of an arm: of a planar one by its masses, of any other by its model."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import mujoco
import numpy as np
from numpy.typing import NDArray

from armtwin.models.arm import Arm
from armtwin.models.errors import RecordingError, nearest, shown
from armtwin.models.motion.model_file import load_model
from armtwin.models.recordings.moving import ModelArm
from armtwin.models.units import MM_PER_M

Array = NDArray[np.float64]


def gravity_torques(arm: Arm | ModelArm, q: Array) -> Array | None:
    """(N, n) torque, N m, with which each joint holds the arm at rest at (N, n) angles, rad.

    None where the recording does not say what the arm weighs, or where it lies flat. Raises `RecordingError` for a
    model that does not load or lacks a joint.
    """
    if isinstance(arm, ModelArm):
        torques = _of_model(arm, q)
    elif arm.link_masses_kg is None:
        return None
    else:
        torques = _of_links(arm, q)
    return torques if np.abs(torques).max() > 0.0 else None


def tip_torques(arm: Arm | ModelArm, q: Array) -> Array | None:
    """(N, n) torque, N m, for each kilogram at the tip of a planar arm or at the last body of a model, or None."""
    if isinstance(arm, Arm):
        empty = replace(arm, link_masses_kg=np.zeros(arm.n_joints), tip_mass_kg=1.0)
        torques = _of_links(empty, q)
    else:
        torques = _at_last_body(arm, q)
    return torques if np.abs(torques).max() > 0.0 else None


def _of_links(arm: Arm, q: Array) -> Array:
    """Sum the moments of all masses beyond a joint: links weigh at their middle, the tip's mass at the tip."""
    assert arm.link_masses_kg is not None
    heading = np.cumsum(q + arm.zero_pose_rad, axis=1)
    lengths = arm.link_lengths_mm / MM_PER_M
    links = lengths[: arm.n_joints] * np.exp(1j * heading)
    if arm.has_tip_offset:
        links[:, -1] += 1j * lengths[-1] * np.exp(1j * heading[:, -1])
    ends = np.cumsum(links, axis=1)
    axes = np.concatenate([np.zeros((len(q), 1)), ends[:, :-1]], axis=1)
    masses = [*arm.link_masses_kg, arm.tip_mass_kg or 0.0]
    places = [*(axes + links / 2).T, ends[:, -1]]
    pull = complex(*arm.gravity_m_s2)
    out = np.zeros_like(q)
    for joint in range(arm.n_joints):
        for number in range(joint, len(masses)):
            arm_to = places[number] - axes[:, joint]
            out[:, joint] -= masses[number] * np.imag(np.conj(arm_to) * pull)
    return out


def _of_model(arm: ModelArm, q: Array) -> Array:
    def held(model: mujoco.MjModel, data: mujoco.MjData, last: int) -> Array:
        mujoco.mj_comVel(model, data)
        mujoco.mj_rne(model, data, 0, data.qfrc_bias)
        return np.array(data.qfrc_bias)

    return _in_each_pose(arm, q, held)


def _at_last_body(arm: ModelArm, q: Array) -> Array:
    def held(model: mujoco.MjModel, data: mujoco.MjData, last: int) -> Array:
        slope = np.zeros((3, model.nv))
        mujoco.mj_jacBodyCom(model, data, slope, None, last)
        return np.asarray(-(model.opt.gravity @ slope))

    return _in_each_pose(arm, q, held)


def _in_each_pose(arm: ModelArm, q: Array, held: Callable[[mujoco.MjModel, mujoco.MjData, int], Array]) -> Array:
    """(N, n) what `held` (model, data, the last joint's body) says of all its hinges, at the arm's own, N m."""
    model = load_model(arm.model)
    data = mujoco.MjData(model)
    rows = [_joint(model, name, arm.model.name) for name in arm.joints]
    places, dofs = [int(model.jnt_qposadr[j]) for j in rows], [int(model.jnt_dofadr[j]) for j in rows]
    last = int(model.jnt_bodyid[rows[-1]])
    out = np.empty_like(q)
    for row, angles in enumerate(q):
        data.qpos[places] = angles
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        out[row] = held(model, data, last)[dofs]
    return out


def _joint(model: mujoco.MjModel, name: str, file: str) -> int:
    number = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, name)
    if number < 0:
        names: Sequence[str] = [model.joint(k).name for k in range(model.njnt)]
        raise RecordingError(f"recording.json: arm.joints: {file} has no joint '{shown(name)}'{nearest(name, names)}")
    if model.jnt_type[number] != mujoco.mjtJoint.mjJNT_HINGE:
        raise RecordingError(f"recording.json: arm.joints: '{shown(name)}' of {file} is no hinge; angles are wanted")
    return int(number)
