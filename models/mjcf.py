"""The arm as a MuJoCo model, built with `MjSpec` from an arm, its deviation and its servo.

World frame: the robot frame in metres, origin at marker A, x right, y up, z towards the camera. Names, with i from 1:

    body link{i}    turns on joint{i}; its x axis runs along the link
    body mid{i}     only where link i may bend: its middle piece
    body end{i}     rides rigidly at the far end of link i and carries its marker and what follows
    joint{i}        the servo's output shaft, turned by actuator servo{i}
    site marker_m   centre of sticker m: `a` on the base, the next one at the end of each link (and maybe on its corner)

Whatever is to give, play or lag at joint i is a further hinge of body link{i} on the same axis (a series element);
whatever is to bend along link i are hinges of its bodies mid{i} and end{i}, at `BEND_AT` along it.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator
from contextlib import contextmanager

import mujoco
import numpy as np
from numpy.typing import NDArray

from armtwin.models.arm import Arm
from armtwin.models.catalogue.context import TYPICAL_LINK_MASS_KG, TYPICAL_TIP_MASS_KG
from armtwin.models.errors import InputError
from armtwin.models.kinematics import Deviation, complex_links
from armtwin.models.servo import Servo
from armtwin.models.units import M_PER_MM

Array = NDArray[np.float64]

# Springs beyond the servo are damped to answer in this time, as fast as the servo's loop itself.
SPRING_TIME_S = 0.020
# Bodies without weight of their own (link ends) need some for MuJoCo; a sticker's.
_STICKER_KG = 1e-6
_STICKER_INERTIA_KG_M2 = 1e-9
# Constraint stiffness: two of the finest time steps (MuJoCo allows no less than two of those in use), and its hardest
# impedance, so that friction holds without creep (measured: below 1e-5 rad a pose) and limits give less than 1e-5 rad
# under the servo's stall torque.
SOLREF = [0.002, 1.0]
SOLIMP = [0.9999, 0.9999, 0.001, 0.5, 2.0]
# How far beyond the heaviest pose a servo must be able to hold (TowerPro's sheet gives no holding torque).
_TORQUE_RESERVE = 3.0

# Keeps coaxial hinges apart numerically; about a nominal rotor's, and no resting angle depends on it.
HINGE_INERTIA_KG_M2 = 1e-3

# Two hinges at Gauss's points of a link deflect and turn its end exactly as a bent beam does, for end loads and for
# its own even weight (the moments times the lever arms are polynomials of degree 3 along it).
BEND_AT = (0.5 - 0.5 / math.sqrt(3.0), 0.5 + 0.5 / math.sqrt(3.0))

_LINK_RGBA = [0.12, 0.12, 0.13, 1.0]
_SERVO_RGBA = [0.05, 0.05, 0.06, 1.0]
_STICKER_RGBA = [0.85, 0.08, 0.08, 1.0]
_STICKER_RADIUS_M = 0.005
_LINK_HALF_WIDTH_M = 0.0075
_LINK_HALF_DEPTH_M = 0.006


def build_arm(
    arm: Arm, servo: Servo, deviation: Deviation | None = None, bendable: Collection[int] = ()
) -> mujoco.MjSpec:
    """Return the spec of `arm` with its lengths and joint zeros deviated; compile it with `spec.compile()`.

    Links whose number is in `bendable` are cut in three pieces, still rigidly joined.
    """
    spec = _empty_spec(arm, servo)
    links = complex_links(arm, deviation) * M_PER_MM
    zeros = arm.zero_pose_rad + (0.0 if deviation is None else deviation.joints_rad)
    masses = link_masses_kg(arm)
    torque = _torque_limit_nm(arm, servo)
    _add_marker(spec.worldbody, arm.marker_names[0], [0.0, 0.0, 0.0])
    parent = spec.worldbody
    for i, link in enumerate(links):
        body = parent.add_body(name=f"link{i + 1}", quat=_turn_about_z(zeros[i]))
        at = np.array([link.real, link.imag, 0.0])
        _add_servo(spec, body, i + 1, servo, torque, _reach_inertia(links, masses, tip_mass_kg(arm), i))
        _draw_link(body, at)
        last = i == len(links) - 1
        tip = tip_mass_kg(arm) if last else 0.0
        if i + 1 in bendable:
            near, far = BEND_AT
            _give_rod_mass(body, masses[i] * near, 0.0 * at, near * at)
            middle = body.add_body(name=f"mid{i + 1}", pos=near * at)
            _give_rod_mass(middle, masses[i] * (far - near), 0.0 * at, (far - near) * at)
            end = middle.add_body(name=f"end{i + 1}", pos=(1.0 - near) * at)
            _give_rod_mass(end, masses[i] * (1.0 - far), (far - 1.0) * at, 0.0 * at, tip)
        else:
            _give_rod_mass(body, masses[i], 0.0 * at, at)
            end = body.add_body(name=f"end{i + 1}", pos=at)
            _give_rod_mass(end, 0.0, 0.0 * at, 0.0 * at, tip)
        _add_marker(end, arm.marker_names[i + 1], [0.0, 0.0, 0.0])
        if last and arm.form.corner is not None:
            _add_marker(body, arm.form.corner, [link.real, 0.0, 0.0])
        parent = end
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
    hinge = spec.body(f"link{joint}").add_joint(name=name, axis=axis, armature=HINGE_INERTIA_KG_M2)
    hinge.solref_limit = SOLREF
    hinge.solimp_limit = SOLIMP
    return hinge


def add_spring(spec: mujoco.MjSpec, joint: int, name: str, compliance_rad_per_nm: float) -> mujoco.MjsJoint:
    """Add to link `joint` (from 1) a damped torsion spring in series with its servo."""
    hinge = add_series_hinge(spec, joint, name)
    hinge.stiffness[0] = 1.0 / compliance_rad_per_nm
    hinge.damping[0] = SPRING_TIME_S / compliance_rad_per_nm
    return hinge


def ride_on_link(spec: mujoco.MjSpec, marker: str, number: int) -> None:
    """Let sticker `marker`, which sits at the root of link `number`, ride on that link instead of the one before."""
    for old, add in (
        (spec.site(f"marker_{marker}"), spec.body(f"link{number}").add_site),
        (spec.geom(f"sticker_{marker}"), spec.body(f"link{number}").add_geom),
    ):
        kept = {name: getattr(old, name) for name in ("name", "type", "pos", "size", "rgba")}
        spec.delete(old)
        new = add(**kept)
        if isinstance(new, mujoco.MjsGeom):
            new.contype, new.conaffinity = 0, 0


def add_tip_mass(model: mujoco.MjModel, body: int, mass_kg: float) -> None:
    """Add a point mass to a compiled `body`, and to the subtrees that it belongs to."""
    model.body_mass[body] += mass_kg
    while body > 0:
        model.body_subtreemass[body] += mass_kg
        body = int(model.body_parentid[body])
    model.body_subtreemass[0] += mass_kg


def heaviest_torque_nm(arm: Arm, joint: int = 1) -> float:
    """Torque of gravity about `joint` (from 1) with the arm stretched out square to it."""
    links, masses = np.abs(complex_links(arm))[joint - 1 :] * M_PER_MM, link_masses_kg(arm)[joint - 1 :]
    ends = np.cumsum(links)
    moment = float(masses @ (ends - links / 2) + tip_mass_kg(arm) * ends[-1])
    return moment * float(np.hypot(*arm.gravity_m_s2))


def _empty_spec(arm: Arm, servo: Servo) -> mujoco.MjSpec:
    spec = mujoco.MjSpec()
    spec.modelname = arm.name
    spec.compiler.degree = False
    spec.option.timestep = servo.timestep_s
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.gravity = [*arm.gravity_m_s2, 0.0]
    spec.option.disableflags = int(mujoco.mjtDisableBit.mjDSBL_CONTACT)
    return spec


def _turn_about_z(angle: float) -> list[float]:
    return [math.cos(angle / 2), 0.0, 0.0, math.sin(angle / 2)]


def _give_rod_mass(body: mujoco.MjsBody, mass: float, start: Array, end: Array, end_mass: float = 0.0) -> None:
    """Spread `mass` evenly from `start` to `end` (body axes, m) and put a point `end_mass` at `end`."""
    total = max(mass + end_mass, _STICKER_KG)
    centre = ((start + end) / 2 * mass + end * end_mass) / total
    length2 = float((end - start) @ (end - start))
    apart = mass * end_mass / total * length2 / 4  # parallel axes: the rod's middle and the point mass
    across = mass * length2 / 12 + apart + _STICKER_INERTIA_KG_M2
    body.explicitinertial = True
    body.mass = total
    body.ipos = centre
    body.inertia = [across, across, across]


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
    inertia = inertia_kg_m2 + servo.rotor_inertia_kg_m2
    damping = max(stiffness * servo.loop_time_s, 2.0 * math.sqrt(stiffness * inertia))
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
    return max(servo.stall_torque_nm, _TORQUE_RESERVE * heaviest_torque_nm(arm))


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


@contextmanager
def building() -> Iterator[None]:
    """Tell MuJoCo's refusal of a model as the user's mistake that it is.

    Raises:
        InputError: no arm can be so: a mass, a spring or a gap that nothing has, or one thing twice.

    """
    try:
        yield
    except ValueError as error:
        why = " ".join(str(error).removeprefix("Error:").split())
        twice = "; the same effect stands twice at one place, give it once" if "repeated name" in why else ""
        raise InputError(f"no such arm can be built ({why}){twice}") from None
