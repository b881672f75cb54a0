"""The arm as a MuJoCo model, built with `MjSpec` from an arm, its deviation and its servo.

World frame: the robot frame in metres, origin at marker A, x right, y up, z towards the camera. Names, with i from 1:

    body link{i}    turns on joint{i}; its x axis runs along the link
    body end{i}     rides rigidly at the far end of link i and carries its marker and what follows
    joint{i}        the servo's output shaft, turned by actuator servo{i}
    site marker_m   centre of sticker m: `a` on the base, the next one at the end of each link (planar3 has `e` too)

Whatever is to give, play or lag at joint i is a further hinge of body link{i} on the same axis (a series element);
whatever is to bend along link i is a hinge of body end{i} with its anchor on the link.
"""

from __future__ import annotations

import math

import mujoco
import numpy as np
from numpy.typing import NDArray

from models.arm import Arm
from models.effects.context import TYPICAL_LINK_MASS_KG, TYPICAL_TIP_MASS_KG
from models.kinematics import Deviation, complex_links
from models.servo import Servo
from models.units import M_PER_MM

Array = NDArray[np.float64]

# The servo's loop answers in five of these steps and nothing else moves faster; half of it changes no resting angle.
TIMESTEP_S = 0.004
# Answer time of the servo's loop: one period of the command pulses.
LOOP_TIME_S = 0.020
# Bodies without weight of their own (link ends) need some for MuJoCo; a sticker's.
_STICKER_KG = 1e-6
_STICKER_INERTIA_KG_M2 = 1e-9
# Constraint stiffness: two time steps, and MuJoCo's hardest impedance, so that friction holds without creep (measured:
# below 1e-5 rad a pose) and limits give less than 1e-5 rad under the servo's stall torque.
SOLREF = [2 * TIMESTEP_S, 1.0]
SOLIMP = [0.9999, 0.9999, 0.001, 0.5, 2.0]
# How far beyond the heaviest pose a servo must be able to hold (TowerPro's sheet gives no holding torque).
_TORQUE_RESERVE = 3.0

_LINK_RGBA = [0.12, 0.12, 0.13, 1.0]
_SERVO_RGBA = [0.05, 0.05, 0.06, 1.0]
_STICKER_RGBA = [0.85, 0.08, 0.08, 1.0]
_STICKER_RADIUS_M = 0.005
_LINK_HALF_WIDTH_M = 0.0075
_LINK_HALF_DEPTH_M = 0.006


def build_arm(arm: Arm, servo: Servo, deviation: Deviation | None = None) -> mujoco.MjSpec:
    """Return the spec of `arm` with its lengths and joint zeros deviated; compile it with `spec.compile()`."""
    spec = _empty_spec(arm)
    links = complex_links(arm, deviation) * M_PER_MM
    zeros = arm.zero_pose_rad + (0.0 if deviation is None else deviation.joints_rad)
    masses = link_masses_kg(arm)
    torque = _torque_limit_nm(arm, servo)
    _add_marker(spec.worldbody, arm.marker_names[0], [0.0, 0.0, 0.0])
    parent, at = spec.worldbody, np.zeros(3)
    for i, link in enumerate(links):
        body = parent.add_body(name=f"link{i + 1}", pos=at, quat=_turn_about_z(zeros[i]))
        at = np.array([link.real, link.imag, 0.0])
        _give_rod_mass(body, masses[i], at)
        _add_servo(spec, body, i + 1, servo, torque, _reach_inertia(links, masses, tip_mass_kg(arm), i))
        _draw_link(body, at)
        end = body.add_body(name=f"end{i + 1}", pos=at)
        last = i == len(links) - 1
        _give_point_mass(end, tip_mass_kg(arm) if last else 0.0)
        _add_marker(end, arm.marker_names[i + 1], [0.0, 0.0, 0.0])
        if last and arm.is_planar3:
            _add_marker(body, "e", [link.real, 0.0, 0.0])
        parent, at = end, np.zeros(3)
    return spec


def link_masses_kg(arm: Arm) -> Array:
    """(n,) mass of each link, as declared or typical."""
    if arm.link_masses_kg is not None:
        return np.asarray(arm.link_masses_kg, dtype=float)
    return np.full(arm.n_joints, TYPICAL_LINK_MASS_KG)


def tip_mass_kg(arm: Arm) -> float:
    """Mass at the tip, as declared or typical."""
    return TYPICAL_TIP_MASS_KG if arm.tip_mass_kg is None else float(arm.tip_mass_kg)


def add_series_hinge(spec: mujoco.MjSpec, joint: int, name: str) -> mujoco.MjsJoint:
    """Add to link `joint` (from 1) a second hinge on the axis of its servo: a place where it can give or play."""
    axis = spec.joint(f"joint{joint}").axis
    # The rotor's inertia again: it keeps the two coaxial hinges apart numerically and changes no resting angle.
    hinge = spec.body(f"link{joint}").add_joint(name=name, axis=axis, armature=spec.joint(f"joint{joint}").armature)
    hinge.solref_limit = SOLREF
    hinge.solimp_limit = SOLIMP
    return hinge


def _empty_spec(arm: Arm) -> mujoco.MjSpec:
    spec = mujoco.MjSpec()
    spec.modelname = arm.name
    spec.compiler.degree = False
    spec.option.timestep = TIMESTEP_S
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.gravity = [*arm.gravity_m_s2, 0.0]
    spec.option.disableflags = int(mujoco.mjtDisableBit.mjDSBL_CONTACT)
    return spec


def _turn_about_z(angle: float) -> list[float]:
    return [math.cos(angle / 2), 0.0, 0.0, math.sin(angle / 2)]


def _give_rod_mass(body: mujoco.MjsBody, mass: float, end: Array) -> None:
    """Spread `mass` evenly from the joint to `end` (the third link's straight line from C to F)."""
    length = float(np.hypot(end[0], end[1]))
    across = mass * length**2 / 12 + _STICKER_INERTIA_KG_M2
    body.explicitinertial = True
    body.mass = max(mass, _STICKER_KG)
    body.ipos = end / 2
    body.inertia = [across, across, across]


def _give_point_mass(body: mujoco.MjsBody, mass: float) -> None:
    body.explicitinertial = True
    body.mass = max(mass, _STICKER_KG)
    body.inertia = [_STICKER_INERTIA_KG_M2] * 3


def _add_servo(
    spec: mujoco.MjSpec, body: mujoco.MjsBody, number: int, servo: Servo, torque_nm: float, inertia_kg_m2: float
) -> None:
    body.add_joint(
        name=f"joint{number}",
        axis=[0, 0, 1],
        armature=servo.rotor_inertia_kg_m2,
        # MuJoCo's default friction is soft: it yields below about 0.02 rad/s, so the ideal servo does not stick.
        frictionloss=servo.friction_nm,
    )
    stiffness = servo.stiffness_nm_rad
    # At least critically damped: an overshoot would be remembered by play and friction.
    damping = max(stiffness * LOOP_TIME_S, 2.0 * math.sqrt(stiffness * inertia_kg_m2))
    actuator = spec.add_actuator(
        name=f"servo{number}", target=f"joint{number}", trntype=mujoco.mjtTrn.mjTRN_JOINT, forcelimited=True
    )
    actuator.forcerange = [-torque_nm, torque_nm]
    actuator.set_to_pid(
        kp=stiffness, kv=damping, slewmax=servo.approach_speed_rad_s, ctrlspec=int(mujoco.mjtCtrlInput.mjINPUT_POS)
    )


def _reach_inertia(links: NDArray[np.complex128], masses: Array, tip: float, first: int) -> float:
    """Inertia about joint `first` (from 0) of the arm stretched out beyond it, kg m2."""
    inertia, reach = 0.0, 0.0
    for link, mass in zip(np.abs(links[first:]), masses[first:], strict=True):
        inertia += mass * ((reach + link / 2) ** 2 + link**2 / 12)
        reach += link
    return float(inertia + tip * reach**2)


def _torque_limit_nm(arm: Arm, servo: Servo) -> float:
    """Stall torque; an arm that a recording shows standing but this servo could not lift has a stronger one."""
    links, masses = np.abs(complex_links(arm)) * M_PER_MM, link_masses_kg(arm)
    ends = np.cumsum(links)
    moment = float(masses @ (ends - links / 2) + tip_mass_kg(arm) * ends[-1])
    return max(servo.stall_torque_nm, _TORQUE_RESERVE * moment * float(np.hypot(*arm.gravity_m_s2)))


def _add_marker(body: mujoco.MjsBody, name: str, pos: list[float]) -> None:
    body.add_site(name=f"marker_{name}", pos=pos)
    body.add_geom(
        name=f"sticker_{name}",
        type=mujoco.mjtGeom.mjGEOM_CYLINDER,
        pos=[pos[0], pos[1], pos[2] - 0.0001],
        size=[_STICKER_RADIUS_M, 0.0001, 0.0],
        rgba=_STICKER_RGBA,
        contype=0,
        conaffinity=0,
    )


def _draw_link(body: mujoco.MjsBody, end: Array) -> None:
    """Draw the printed link and the servo at its root, behind the markers' plane; neither touches anything."""
    depth = -2 * _LINK_HALF_DEPTH_M
    body.add_geom(
        type=mujoco.mjtGeom.mjGEOM_BOX,
        pos=[end[0] / 2, end[1] / 2, depth / 2 - 0.0005],
        quat=_turn_about_z(math.atan2(end[1], end[0])),
        size=[float(np.hypot(end[0], end[1])) / 2, _LINK_HALF_WIDTH_M, _LINK_HALF_DEPTH_M],
        rgba=_LINK_RGBA,
        contype=0,
        conaffinity=0,
    )
    body.add_geom(
        type=mujoco.mjtGeom.mjGEOM_BOX,
        pos=[-0.010, 0.0, depth - 0.022],
        size=[0.02035, 0.00985, 0.0215],  # MG996R: 40.7 mm x 19.7 mm x 42.9 mm
        rgba=_SERVO_RGBA,
        contype=0,
        conaffinity=0,
    )
