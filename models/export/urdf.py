"""A twin as a URDF file: the calibrated geometry, the joint zeros in `<origin>`, masses, limits and dynamics.

Joint zeros never go into `<calibration>`: MuJoCo ignores it, and drivers that obey it move the robot by it. URDF has no
play, no spring behind a joint and no servo; what it cannot hold stands in the note beside the file.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path

import mujoco
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from armtwin.models import atomic
from armtwin.models.arm import Arm
from armtwin.models.export.held import Held, held_by_rigid_links, label
from armtwin.models.export.mjcf import note_beside, note_of
from armtwin.models.twin import Twin, rebuild
from armtwin.models.world import World

Array = NDArray[np.float64]

READERS_DROP = (
    "MuJoCo's importer and others read no <calibration> and drop <dynamics> without a word",
    "many importers merge links that are joined rigidly (MuJoCo: fusestatic, turned off in this file)",
    "URDF says nothing of servos: effort and velocity are limits, a controller is up to the reader",
)


def urdf_text(twin: Twin) -> str:
    """Return the URDF of a twin's arm, SI units, base frame at marker A: x right, y up, z towards the camera."""
    world = rebuild(twin)
    model = world.compile()
    data = mujoco.MjData(model)
    for event in sorted(world.events, key=lambda event: event.sample):
        event.happen(model, data)
    robot = ET.Element("robot", name=twin.arm.name)
    robot.append(ET.Comment(_comment(held_by_rigid_links(twin))))
    hints = ET.SubElement(robot, "mujoco")
    ET.SubElement(hints, "compiler", fusestatic="false", discardvisual="false", strippath="false")
    ET.SubElement(robot, "link", name="base")
    for number in range(1, model.nbody):
        _add_body(robot, model, number, world)
    for number in range(model.nsite):
        _add_frame(robot, model, number)
    ET.indent(robot, " ")
    return "<?xml version='1.0' encoding='utf-8'?>\n" + ET.tostring(robot, encoding="unicode") + "\n"


def export_urdf(twin: Twin, path: Path) -> Held:
    """Write `path` (URDF) and beside it `<stem>.armtwin.json`: what the file does not hold, and what readers drop."""
    held = held_by_rigid_links(twin)
    atomic.write_text(path, urdf_text(twin))
    atomic.write_json(note_beside(path), {**note_of(twin, held, "urdf", path.name), "readers_drop": READERS_DROP})
    return held


def xyz(values: Array) -> str:
    """Return three numbers as URDF has them; a rounding error's worth of angle or length is none."""
    return " ".join(f"{0.0 if abs(value) < 1e-12 else value:.10g}" for value in values)


def _add_body(robot: ET.Element, model: mujoco.MjModel, number: int, world: World) -> None:
    servo = world.servo
    body = model.body(number)
    link = ET.SubElement(robot, "link", name=body.name)
    inertial = ET.SubElement(link, "inertial")
    _origin(inertial, body.ipos, body.iquat)
    ET.SubElement(inertial, "mass", value=f"{float(body.mass[0]):.10g}")
    ixx, iyy, izz = (f"{value:.10g}" for value in body.inertia)
    ET.SubElement(inertial, "inertia", ixx=ixx, ixy="0", ixz="0", iyy=iyy, iyz="0", izz=izz)
    for geom in range(int(body.geomadr[0]), int(body.geomadr[0]) + int(body.geomnum[0])):
        if model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_BOX:
            visual = ET.SubElement(link, "visual")
            _origin(visual, model.geom_pos[geom], model.geom_quat[geom])
            ET.SubElement(ET.SubElement(visual, "geometry"), "box", size=xyz(2.0 * model.geom_size[geom]))
    parent = int(body.parentid[0])
    turns = body.name.startswith("link")
    joint = ET.SubElement(
        robot,
        "joint",
        name=_joint_name(world.arm, body.name) if turns else f"to_{body.name}",
        type="revolute" if turns else "fixed",
    )
    ET.SubElement(joint, "parent", link="base" if parent == 0 else model.body(parent).name)
    ET.SubElement(joint, "child", link=body.name)
    _origin(joint, body.pos, body.quat)
    if turns:
        hinge = model.joint(body.name.replace("link", "joint"))
        actuator = model.actuator(body.name.replace("link", "servo"))
        ET.SubElement(joint, "axis", xyz=xyz(hinge.axis))
        low, high = _limits(world, body.name)
        ET.SubElement(
            joint,
            "limit",
            lower=f"{low:.10g}",
            upper=f"{high:.10g}",
            effort=f"{float(actuator.forcerange[1]):.10g}",
            velocity=f"{servo.no_load_speed_rad_s:.10g}",
        )
        ET.SubElement(joint, "dynamics", damping="0", friction=f"{float(hinge.frictionloss[0]):.10g}")


def _joint_name(arm: Arm, link: str) -> str:
    """Return what the drawing calls the joint that turns a link (`link1`, ...), or `joint1` where it names none."""
    return link.replace("link", "joint") if arm.joints is None else arm.joints[int(link.removeprefix("link")) - 1]


def _limits(world: World, link: str) -> tuple[float, float]:
    """Return how far the drawing lets the joint of a link turn, or its servo's travel about the middle, rad."""
    if world.arm.joint_limits_rad is None:
        return -world.servo.travel_rad / 2, world.servo.travel_rad / 2
    low, high = world.arm.joint_limits_rad[int(link.removeprefix("link")) - 1]
    return float(low), float(high)


def _add_frame(robot: ET.Element, model: mujoco.MjModel, number: int) -> None:
    """Add a frame without mass for a marker, so that a reader can ask where the tip is."""
    site = model.site(number)
    ET.SubElement(robot, "link", name=site.name)
    joint = ET.SubElement(robot, "joint", name=f"to_{site.name}", type="fixed")
    body = int(site.bodyid[0])
    ET.SubElement(joint, "parent", link="base" if body == 0 else model.body(body).name)
    ET.SubElement(joint, "child", link=site.name)
    _origin(joint, site.pos, site.quat)


def _origin(parent: ET.Element, position: Array, quaternion: Array) -> None:
    rpy = Rotation.from_quat(np.asarray(quaternion), scalar_first=True).as_euler("xyz")
    ET.SubElement(parent, "origin", xyz=xyz(np.asarray(position)), rpy=xyz(rpy))


def _comment(held: Held) -> str:
    lines = ["A twin measured and exported by armtwin; joint zeros are in the origins. Angles are commands, rad."]
    lines += [f"does not hold {label(one.effect)}, which {one.why}" for one in held.not_held]
    return "; ".join(lines).replace("--", "- -")
