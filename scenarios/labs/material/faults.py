"""Lab 5: five recordings of five arms, each with one thing wrong, and what a twin of the geometry leaves of them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from armtwin.models.arm import Arm, nominal_arm
from armtwin.models.camera import back_project
from armtwin.models.camera_files import nominal_camera
from armtwin.models.kinematics import Deviation, wrap
from armtwin.models.plan import Plan, plan_of
from armtwin.models.recordings.recording import Recording
from armtwin.models.twin import Twin, TwinEffect
from armtwin.scenarios.twins.simulation import simulate

Array = NDArray[np.float64]

POSSIBLE = ("backlash", "camera_moved", "gravity_sag", "joint_slip", "servo_nonlinearity", "thermal_drift")
_BUILT = Deviation(np.array([0.8, -0.6, 0.4, 0.0]), np.array([0.012, -0.020, 0.015]))
_BASE_MM = np.array([8.0, -6.0, -80.87])
_POSES, _LINE = 120, 24
# (effect, joint, parameters) by recording; the notebook does not hold this.
_HIDDEN: dict[str, tuple[str, int | None, dict[str, Any]]] = {
    "A": ("servo_nonlinearity", 1, {"amplitude_rad": 0.012, "cycles_per_turn": 4.0, "phase_rad": 0.4}),
    "B": ("backlash", 2, {"width_rad": 0.018}),
    "C": ("camera_moved", None, {"from_sample": 74, "translation_x_mm": 1.6, "translation_y_mm": -0.9}),
    "D": ("gravity_sag", None, {"compliance1_rad_per_nm": 0.12, "compliance2_rad_per_nm": 0.0}),
    "E": ("joint_slip", 3, {"from_sample": 41, "jump_rad": 0.02}),
}


@dataclass(frozen=True, eq=False)
class JointErrors:
    """What is left of a recording after its geometry: one row a pose, in the order they happened.

    Attributes:
        q_cmd: (N, 3) commands, rad.
        error_rad: (N, 3) measured less commanded angle of each joint, its mean taken out, rad.
        base_mm: (N, 2) where marker A was seen, less its mean, mm; it should not move.
        held_out: (N,) whether a pose belongs to the motion that is kept for judging.

    """

    q_cmd: Array
    error_rad: Array
    base_mm: Array
    held_out: NDArray[np.bool_]


def hidden() -> dict[str, tuple[str, int | None]]:
    """Return what is wrong with each, for the checks."""
    return {name: (effect, joint) for name, (effect, joint, _) in _HIDDEN.items()}


@cache
def recording(name: str) -> Recording:
    """Return recording "A" to "E": a sweep up and down through all angles, and a line that is held out."""
    effect, joint, parameters = _HIDDEN[name]
    arm = _upright()
    twin = Twin(arm, _BUILT, _BASE_MM, nominal_camera(), (TwinEffect(effect, joint, None, parameters),))
    return simulate(twin, _plan(), seed=ord(name), held_out=("line",))


@cache
def joint_errors(name: str) -> JointErrors:
    """Return the joint angles that the markers of a recording show, less the commanded ones."""
    seen = recording(name)
    assert seen.camera is not None
    assert seen.arm_plane_z_mm is not None
    places = [
        back_project(seen.camera, seen.markers_px[marker], seen.arm_plane_z_mm)[:, :2] * [-1.0, 1.0]
        for marker in seen.arm.marker_names
    ]
    z = np.array([place[:, 0] + 1j * place[:, 1] for place in places])
    directions = np.angle(np.diff(z, axis=0)).T
    turned = wrap(np.diff(directions, axis=1, prepend=0.0) - np.pi / 2)
    error = wrap(turned - seen.q_cmd)
    base = places[0]
    return JointErrors(seen.q_cmd, error - error.mean(axis=0), base - base.mean(axis=0), seen.trajectory == "line")


def few_rows() -> NDArray[np.int64]:
    """Return the rows of the sweep that a hurried student would have taken: every sixth."""
    return np.flatnonzero(~joint_errors("A").held_out)[::6]


def _upright() -> Arm:
    arm = nominal_arm()
    return Arm(arm.name, arm.link_lengths_mm, np.array([0.0, -9.81]), arm.link_masses_kg, arm.tip_mass_kg, arm.form)


def _plan() -> Plan:
    turn = np.linspace(0.0, 2.0 * np.pi, _POSES)
    sweep = np.stack(
        [0.35 * np.sin(3 * turn), 0.2 + 0.3 * np.sin(4 * turn + 1.0), -0.3 + 0.4 * np.sin(5 * turn)], axis=-1
    )
    share = np.linspace(0.0, 1.0, _LINE)[:, None]
    there, back = np.array([-0.28, 0.45, -0.6]), np.array([0.3, 0.0, 0.05])
    return plan_of({"sweep": sweep, "line": there + share * (back - there)})
