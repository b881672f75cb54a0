"""Lab 6: two causes that make the same picture on a small circle, and an arm that has one of them."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from armtwin.models.arm import Arm, nominal_arm
from armtwin.models.camera_files import nominal_camera
from armtwin.models.joint_limits import JointLimits
from armtwin.models.kinematics import Deviation, forward_jacobian
from armtwin.models.plan import paper_plan, plan_of
from armtwin.models.twin import Twin, TwinEffect
from armtwin.scenarios.labs.material.tips import tips_of
from armtwin.scenarios.twins.simulation import simulate

Array = NDArray[np.float64]

BUDGET = 20
CAUSES: dict[str, tuple[str, int | None, dict[str, Any]]] = {
    "gravity_sag": ("gravity_sag", None, {"compliance1_rad_per_nm": 0.1}),
    "servo_gain": ("servo_gain", 1, {"gain": 1.03}),
}
# What the sub-pixel detector leaves, in the arm's plane.
NOISE_PX, NOISE_MM = 0.06, 0.02
LIMITS = JointLimits(np.full(3, -np.pi / 2), np.full(3, np.pi / 2), np.pi)
_BASE_MM = np.array([8.0, -6.0, -80.87])
_TRUE, _SEED = "servo_gain", 6


def paper_poses() -> Array:
    """(20, 3) commands, rad, from the paper's small circle: the experiment that has been made."""
    plan = paper_plan(nominal_arm())
    rows = np.flatnonzero(plan.trajectory == "circle_15")
    return plan.q_cmd[rows[np.linspace(0, len(rows) - 1, BUDGET).round().astype(int)]]


def signature(cause: str, q_cmd: Array) -> Array:
    """(N, 2) how far a cause of the usual size moves the tip against A at (N, 3) commands, mm."""
    return _tips(cause, np.asarray(q_cmd, dtype=float), None) - _tips(None, np.asarray(q_cmd, dtype=float), None)


def geometry(q_cmd: Array) -> Array:
    """(2N, 7) how the tip moves with each length, mm, and joint zero, rad; rows x, y, x, y ... (Lab 4)."""
    by_length, by_joint = forward_jacobian(_arm(), np.asarray(q_cmd, dtype=float), Deviation.none(_arm()))
    return np.concatenate([by_length[:, -1], by_joint[:, -1]], axis=-1).reshape(-1, 7)


def measure(q_cmd: Array) -> Array:
    """(N, 2) what the camera says of the arm in question: the tip against A less the drawing's, mm."""
    q = np.asarray(q_cmd, dtype=float)
    return _tips(_TRUE, q, _SEED) - _tips(None, q, None)


def truth() -> str:
    """Return what is wrong with the arm in question, for the checks."""
    return _TRUE


def _arm() -> Arm:
    arm = nominal_arm()
    return Arm(arm.name, arm.link_lengths_mm, np.array([0.0, -9.81]), arm.link_masses_kg, arm.tip_mass_kg, arm.form)


def _tips(cause: str | None, q_cmd: Array, seed: int | None) -> Array:
    effects = () if cause is None else (TwinEffect(CAUSES[cause][0], CAUSES[cause][1], None, CAUSES[cause][2]),)
    built = (
        Deviation.none(_arm())
        if seed is None
        else Deviation(np.array([0.2, -0.15, 0.0, 0.0]), np.array([0.003, -0.003, 0.0]))
    )
    twin = Twin(_arm(), built, _BASE_MM, nominal_camera(), effects)
    recording = simulate(twin, plan_of({"poses": q_cmd}), noise=0.0 if seed is None else NOISE_PX, seed=seed or 0)
    return tips_of(recording, ["poses"]).tip_mm
