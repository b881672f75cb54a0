"""A user's own URDF mended: joint zeros and link lengths of a twin put into the origins, all else left as it is."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from armtwin.models import atomic
from armtwin.models.errors import InputError, listed, nearest, shown
from armtwin.models.export.held import Held, held_by_rigid_links
from armtwin.models.export.mjcf import note_beside, note_of
from armtwin.models.export.urdf import READERS_DROP, xyz
from armtwin.models.kinematics import complex_links
from armtwin.models.twin import Twin

Array = NDArray[np.float64]

_MAX_BYTES = 1 << 24
_TURNING = ("revolute", "continuous")
# A link of the file and of the drawing that differ by more are not the same link.
_SAME_LENGTH = 0.1


def export_onto_urdf(
    twin: Twin, robot: Path, path: Path, joints: Sequence[str] | None = None, tip: str | None = None
) -> Held:
    """Write `robot`, with the twin's joint zeros and lengths, to `path`, and the note beside it.

    `joints` names the twin's joints in the file; by default they are all that turn, base first. `tip` is
    the link at the arm's tip, by default where the last link's chain ends or branches. Raises `InputError` where there
    are not as many joints, or a link is not as long as the twin's drawing.
    """
    tree = _read(robot)
    elements = _joints_of(tree, robot.name, twin.arm.n_joints, joints)
    if tip is not None and tip not in {link.get("name") for link in tree.findall("link")}:
        raise InputError(f"{robot.name}: has no link '{shown(tip)}'")
    notes = _mend(twin, tree, elements, tip, robot.name)
    held = held_by_rigid_links(twin)
    text = "<?xml version='1.0' encoding='utf-8'?>\n" + ET.tostring(tree, encoding="unicode") + "\n"
    atomic.write_text(path, text)
    note = note_of(twin, held, "urdf", path.name)
    atomic.write_json(note_beside(path), {**note, "onto": robot.name, "notes": notes, "readers_drop": READERS_DROP})
    return held


def _read(path: Path) -> ET.Element:
    if not path.is_file():
        raise InputError(f"{path}: no such file; --onto takes a URDF")
    if path.stat().st_size > _MAX_BYTES:
        raise InputError(f"{path.name}: larger than {_MAX_BYTES} bytes")
    data = path.read_bytes()
    if b"<!DOCTYPE" in data or b"<!ENTITY" in data:
        raise InputError(f"{path.name}: defines entities; write them out (a URDF needs none)")
    try:
        parser = ET.XMLParser(target=ET.TreeBuilder(insert_comments=True))  # noqa: S314  no entities, bounded size
        root = ET.fromstring(data, parser)  # noqa: S314
    except (ET.ParseError, LookupError, ValueError) as error:  # LookupError: an encoding that nobody knows
        raise InputError(f"{path.name}: not XML ({shown(str(error))}); a URDF is wanted, run xacro first") from None
    if root.tag != "robot":
        raise InputError(f"{path.name}: its root is <{shown(str(root.tag))}>, <robot> is wanted: a URDF")
    return root


def _joints_of(robot: ET.Element, file: str, n: int, names: Sequence[str] | None) -> list[ET.Element]:
    every = {joint.get("name", ""): joint for joint in robot.findall("joint")}
    if names is not None:
        for name in names:
            if name not in every:
                raise InputError(f"{file}: has no joint '{shown(name)}'{nearest(name, every)}")
        found = [every[name] for name in names]
    else:
        found = [joint for joint in _from_the_base(robot) if joint.get("type") in _TURNING]
    if len(found) != n:
        turning = listed([joint.get("name", "") for joint in found])
        raise InputError(f"{file}: {len(found)} joints turn ({turning}), the twin has {n}; name them with --joints")
    return found


def _from_the_base(robot: ET.Element) -> list[ET.Element]:
    """List the joints from the base outwards."""
    by_parent: dict[str, list[ET.Element]] = {}
    children = set()
    for joint in robot.findall("joint"):
        by_parent.setdefault(_link(joint, "parent"), []).append(joint)
        children.add(_link(joint, "child"))
    waiting = [link.get("name", "") for link in robot.findall("link") if link.get("name") not in children]
    ordered: list[ET.Element] = []
    while waiting:
        for joint in by_parent.pop(waiting.pop(0), []):
            ordered.append(joint)
            waiting.append(_link(joint, "child"))
    return ordered


def _mend(twin: Twin, robot: ET.Element, joints: list[ET.Element], tip: str | None, file: str) -> list[str]:
    drawn, built = complex_links(twin.arm), complex_links(twin.arm, twin.deviation)
    notes = []
    for number, joint in enumerate(joints):
        axis = _numbers(joint.find("axis"), "xyz", [1.0, 0.0, 0.0], file)
        axis = axis / np.linalg.norm(axis)
        if number + 1 < len(joints):
            way = _way(robot, _link(joint, "child"), _link(joints[number + 1], "parent"))
            way = None if way is None else [*way, joints[number + 1]]
        else:
            way = _way(robot, _link(joint, "child"), tip or _only_end(robot, _link(joint, "child")))
        if way:
            _lengthen(way, axis, built[number] / drawn[number], abs(drawn[number]), file)
        else:
            notes.append(
                f"link {number + 1} ends in no frame of the file that can be told: its length (built "
                f"{abs(built[number]):.3f} mm, drawn {abs(drawn[number]):.3f} mm) was left as it is; name the tip"
            )
    for number, joint in enumerate(joints):
        axis = _numbers(joint.find("axis"), "xyz", [1.0, 0.0, 0.0], file)
        zero = Rotation.from_rotvec(axis / np.linalg.norm(axis) * twin.deviation.joints_rad[number])
        _origin(joint).set("rpy", xyz((_turn(joint, file) * zero).as_euler("xyz")))
    return notes


def _way(robot: ET.Element, start: str, end: str) -> list[ET.Element] | None:
    """Return the rigid joints from link `start` out to link `end`, or None where it does not hang there rigidly."""
    above = {_link(joint, "child"): joint for joint in robot.findall("joint")}
    way: list[ET.Element] = []
    while end != start:
        joint = above.pop(end, None)
        if joint is None or joint.get("type") != "fixed":
            return None
        way.insert(0, joint)
        end = _link(joint, "parent")
    return way


def _only_end(robot: ET.Element, start: str) -> str:
    """Return the link at the end of the chain that hangs on `start`, as far as it does not branch."""
    below: dict[str, list[str]] = {}
    for joint in robot.findall("joint"):
        below.setdefault(_link(joint, "parent"), []).append(_link(joint, "child"))
    while len(below.get(start, [])) == 1:
        start = below.pop(start)[0]
    return start


def _lengthen(way: list[ET.Element], axis: Array, change: complex, drawn_mm: float, file: str) -> None:
    """Move the first frame along `way` so that its last one lies where the built link ends."""
    place, turned = np.zeros(3), Rotation.identity()
    for joint in way:
        place = place + turned.apply(_numbers(joint.find("origin"), "xyz", [0.0, 0.0, 0.0], file))
        turned = turned * _turn(joint, file)
    across = place - axis * (axis @ place)
    length_mm = 1e3 * float(np.linalg.norm(across))
    if abs(length_mm - drawn_mm) > _SAME_LENGTH * drawn_mm:
        raise InputError(
            f"{file}: joint '{shown(way[-1].get('name', ''))}' lies {length_mm:.1f} mm from the axis before, the "
            f"twin's drawing has {drawn_mm:.1f} mm; is this the same arm?"
        )
    wanted = Rotation.from_rotvec(axis * np.angle(change)).apply(across) * abs(change)
    first = _origin(way[0])
    first.set("xyz", xyz(_numbers(first, "xyz", [0.0, 0.0, 0.0], file) + wanted - across))


def _origin(joint: ET.Element) -> ET.Element:
    found = joint.find("origin")
    return ET.SubElement(joint, "origin") if found is None else found


def _turn(joint: ET.Element, file: str) -> Rotation:
    return Rotation.from_euler("xyz", _numbers(joint.find("origin"), "rpy", [0.0, 0.0, 0.0], file))


def _link(joint: ET.Element, which: str) -> str:
    element = joint.find(which)
    return "" if element is None else element.get("link", "")


def _numbers(element: ET.Element | None, key: str, default: list[float], file: str) -> Array:
    text = None if element is None else element.get(key)
    if text is None:
        return np.array(default)
    try:
        values = np.array([float(word) for word in text.split()])
    except ValueError:
        values = np.array([])
    if values.shape != (3,) or not np.isfinite(values).all() or (key == "xyz" and not np.abs(values).max() < 1e6):
        raise InputError(f'{file}: {key}="{shown(text)}", three numbers are wanted')
    return values
