"""Arms for sealed logs: planar by link lengths, upright or flat, or turning about any axes by an MJCF file."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from armtwin.models.arm import Arm
from armtwin.models.motion_arm import MotionArm, arm_of_text, planar_arm

Array = NDArray[np.float64]

_GRAVITY_M_S2 = 9.81
MODEL_FILE = "arm.xml"


@dataclass(frozen=True, eq=False)
class DrawnArm:
    """An arm, what a recording states of it, and the text of its model where it has one."""

    arm: MotionArm
    table: dict[str, Any]
    model: str | None = None


def draw_arm(rng: Generator, n_joints: int, in_gravity: bool) -> DrawnArm:
    """Draw an arm of `n_joints`; `in_gravity` its loads have to vary."""
    if n_joints > 1 and rng.random() < 0.3:
        return _model(rng, n_joints)
    upright = in_gravity or rng.random() < 0.6
    lengths = rng.uniform(60.0, 140.0, n_joints)
    masses = rng.uniform(0.03, 0.12, n_joints)
    tip = float(rng.uniform(0.01, 0.06))
    gravity = np.array([0.0, -_GRAVITY_M_S2 if upright else 0.0])
    arm = Arm("chain", lengths, gravity, masses, tip)
    table = {
        "name": "chain",
        "link_lengths_mm": lengths.tolist(),
        "gravity_m_s2": gravity.tolist(),
        "link_masses_kg": masses.tolist(),
        "tip_mass_kg": tip,
    }
    return DrawnArm(planar_arm(arm), table)


def loads_nm(arm: MotionArm, q: Array, rows: int = 200) -> Array:
    """(n,) largest torque of gravity at each joint over poses (N, n), rad."""
    model = arm.build().compile()
    data = mujoco.MjData(model)
    places = [int(model.joint(name).qposadr[0]) for name in arm.joints]
    dofs = [int(model.joint(name).dofadr[0]) for name in arm.joints]
    most = np.zeros(arm.n_joints)
    for pose in q[:: max(1, len(q) // rows)]:
        data.qpos[places] = pose
        mujoco.mj_forward(model, data)
        most = np.maximum(most, np.abs(data.qfrc_gravcomp[dofs]))
    return most


def _model(rng: Generator, n_joints: int) -> DrawnArm:
    """A turret and links that pitch and roll, as an MJCF file."""
    axes = ["0 0 1", "0 1 0", "0 1 0", "0 1 0", "1 0 0", "0 1 0"][:n_joints]
    names = ["pan", "lift", "elbow", "wrist", "roll", "hand"][:n_joints]
    out, reach = "", 0.05
    for axis, name in zip(axes, names, strict=True):
        mass, length = rng.uniform(0.04, 0.12), rng.uniform(0.05, 0.13)
        around = f"{mass * length**2 / 12 + 1e-6:.6g}"
        out += (
            f'<body name="{name}_link" pos="{reach:.4f} 0 0"><joint name="{name}" type="hinge" axis="{axis}"/>'
            f'<inertial pos="{length / 2:.4f} 0 0" mass="{mass:.4f}" diaginertia="{around} {around} {around}"/>'
        )
        reach = length
    text = (
        f'<mujoco model="drawn"><compiler angle="radian"/><worldbody>{out}{"</body>" * n_joints}</worldbody></mujoco>\n'
    )
    table = {"name": "drawn", "model": MODEL_FILE, "joints": names}
    return DrawnArm(arm_of_text("drawn", text, MODEL_FILE, tuple(names)), table, text)
