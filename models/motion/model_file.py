"""An arm's model (MJCF, URDF) as MuJoCo loads it without its meshes, which often lie elsewhere."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path

import mujoco

from armtwin.models.errors import RecordingError

# What is drawn or touched; a body's inertia stands in <inertial>.
_DRAWN = ("mesh", "hfield", "texture", "material", "skin")
_URDF_DRAWN = ("visual", "collision")
# What hangs on shapes, or drives the joints: what turns them here is the drive of the recording's servo.
_HANGING = ("contact", "sensor", "tendon", "actuator", "keyframe", "equality", "deformable", "custom")


def load_model(path: Path) -> mujoco.MjModel:
    """Compile a model file; raises `RecordingError` where it does not load, or would read another file."""
    return compiled(bare_model(read_model(path), path.name), path.name).compile()


def read_model(path: Path) -> str:
    """Return a model file's text; raises `RecordingError`."""
    try:
        return path.read_text("utf-8-sig")
    except UnicodeDecodeError as error:
        raise RecordingError(f"{path.name}: no XML ({error.reason})") from None
    except OSError as error:
        raise RecordingError(f"{path.name}: cannot be read ({error.strerror})") from None


def bare_model(text: str, file: str) -> str:
    """Return a model without what lies in other files; raises `RecordingError`, naming `file`, for what is none."""
    try:
        root = ET.fromstring(text)  # noqa: S314  (expat bounds what entities expand to)
    except (ET.ParseError, ValueError) as error:
        raise RecordingError(f"{file}: no XML ({error})") from None
    if root.tag not in ("mujoco", "robot"):
        raise RecordingError(f"{file}: begins with <{root.tag[:40]}>; <mujoco> (MJCF) or <robot> (URDF) is wanted")
    if root.find(".//include") is not None:
        raise RecordingError(f"{file}: includes another file; save it as one file (mj_saveLastXML does)")
    if root.find(".//plugin") is not None:
        raise RecordingError(f"{file}: asks for a plugin; only bodies, joints and inertias are read")
    if any(root.find(f"equality/{kind}") is not None for kind in ("connect", "weld")):
        raise RecordingError(f"{file}: closes a loop of bodies (<equality>); an open chain of joints is wanted")
    without_meshes(root)
    return ET.tostring(root, encoding="unicode")


def compiled(text: str, file: str) -> mujoco.MjSpec:
    """Return the model of a bare text, which compiles; raises `RecordingError` that names `file`."""
    try:
        spec = mujoco.MjSpec.from_string(text)
        spec.compile()
    except (ValueError, mujoco.FatalError) as error:
        reason = " ".join(str(error).split())[:200] or "no reason given"
        raise RecordingError(
            f"{file}: the arm's model does not load ({reason}); every body needs its <inertial>"
        ) from None
    return spec


def joint_names(spec: mujoco.MjSpec) -> list[str]:
    """List the hinges of a model, in its order."""
    return [str(joint.name) for joint in spec.joints if joint.type == mujoco.mjtJoint.mjJNT_HINGE]


def without_meshes(root: ET.Element) -> None:
    """Take out of a model all that lies in other files."""
    drawn = _URDF_DRAWN if root.tag == "robot" else ()
    for section in [one for one in root if root.tag == "mujoco" and one.tag in _HANGING]:
        root.remove(section)
    for parent in list(root.iter()):
        for child in list(parent):
            of_mesh = child.tag == "geom" and (child.get("mesh") or child.get("type") in ("mesh", "hfield", "sdf"))
            if child.tag in drawn or of_mesh or (parent.tag == "asset" and child.tag in _DRAWN):
                parent.remove(child)
            else:
                child.attrib.pop("material", None)
    if root.tag == "robot":  # MuJoCo would melt bodies without a joint into their parents, and move the inertias along
        for extension in root.findall("mujoco"):
            root.remove(extension)
