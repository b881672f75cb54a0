"""An arm's model (MJCF, URDF) as MuJoCo loads it without its meshes, which often lie elsewhere."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path

import mujoco

from armtwin.models.errors import RecordingError

# What is drawn or touched; a body's inertia stands in <inertial>.
_DRAWN = ("mesh", "hfield", "texture", "material", "skin")
_URDF_DRAWN = ("visual", "collision")


def load_model(path: Path) -> mujoco.MjModel:
    """Compile a model file; raises `RecordingError` where it does not load, or would read another file."""
    try:
        root = ET.fromstring(path.read_text("utf-8-sig"))  # noqa: S314  (expat bounds what entities expand to)
    except (ET.ParseError, UnicodeDecodeError) as error:
        raise RecordingError(f"{path.name}: no XML ({error})") from None
    if root.tag not in ("mujoco", "robot"):
        raise RecordingError(f"{path.name}: begins with <{root.tag[:40]}>; <mujoco> (MJCF) or <robot> (URDF) is wanted")
    if root.find(".//include") is not None:
        raise RecordingError(f"{path.name}: includes another file; save it as one file (mj_saveLastXML does)")
    if root.find(".//plugin") is not None:
        raise RecordingError(f"{path.name}: asks for a plugin; only bodies, joints and inertias are read")
    without_meshes(root)
    try:
        return mujoco.MjModel.from_xml_string(ET.tostring(root, encoding="unicode"))
    except ValueError as error:
        reason = " ".join(str(error).split())[:200]
        raise RecordingError(
            f"{path.name}: the arm's model does not load ({reason}); every body needs its <inertial>"
        ) from None


def without_meshes(root: ET.Element) -> None:
    """Take out of a model all that lies in other files."""
    drawn = _URDF_DRAWN if root.tag == "robot" else ()
    for parent in list(root.iter()):
        for child in list(parent):
            of_mesh = child.tag == "geom" and (child.get("mesh") or child.get("type") in ("mesh", "hfield", "sdf"))
            if child.tag in drawn or of_mesh or (parent.tag == "asset" and child.tag in _DRAWN):
                parent.remove(child)
            elif child.tag == "geom" and child.get("material"):
                child.attrib.pop("material")
    if root.tag == "robot":  # MuJoCo would melt bodies without a joint into their parents, and move the inertias along
        for extension in root.findall("mujoco"):
            root.remove(extension)
