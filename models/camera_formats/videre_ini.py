"""`.ini` files of Videre's cameras, which ROS's `camera_calibration_parsers` reads and writes: names, then numbers."""

from __future__ import annotations

import re

import numpy as np

from armtwin.models.camera_formats.calibration import Calibration
from armtwin.models.camera_formats.source import Source
from armtwin.models.errors import InputError


def recognises(source: Source) -> bool:
    """Whether the text begins with the section of the image."""
    return re.match(r"\[image\]", source.head) is not None


def read(source: Source) -> Calibration:
    """Read the file's one camera; raises InputError that names section and entry."""
    sections = _sections(source.text)
    cameras = [name for name, entries in sections.items() if "camera matrix" in entries]
    if len(cameras) != 1:
        found = ", ".join(cameras) or "none"
        raise InputError(f"found the cameras {found}, wanted one section with its camera matrix; keep one")
    image, camera = sections.get("image", {}), sections[cameras[0]]
    key = f"[{cameras[0]}] camera matrix"
    if len(camera["camera matrix"]) != 9:
        raise InputError(f"{key}: found {len(camera['camera matrix'])} numbers, wanted 3 rows of 3")
    if "distortion" not in camera:
        raise InputError(f"[{cameras[0]}] distortion: found nothing, wanted its numbers in one row")
    width, height = ([*image.get(name, []), None][0] for name in ("width", "height"))
    return Calibration(
        width=width,
        height=height,
        K=np.array(camera["camera matrix"]).reshape(3, 3),
        model="plumb_bob",
        coefficients=camera["distortion"],
        size_keys=("[image] width", "[image] height"),
        matrix_key=key,
    )


def _sections(text: str) -> dict[str, dict[str, list[float]]]:
    """Entries of each section: a name's line, then the lines of its numbers."""
    sections: dict[str, dict[str, list[float]]] = {}
    section, entry = "", ""
    for number, raw in enumerate(text.splitlines(), start=1):
        line = raw.partition("#")[0].strip()
        head = re.fullmatch(r"\[(.+)\]", line)
        if head:
            section, entry = head.group(1).strip(), ""
            sections.setdefault(section, {})
        elif re.match(r"[-+.\d]", line) and section and entry:
            try:
                values = [float(word) for word in line.split()]
            except ValueError:
                raise InputError(f"line {number}: found {line[:40]!r}, wanted numbers of '{entry}'") from None
            if not np.all(np.isfinite(values)):
                raise InputError(f"line {number}: found a number that is not finite, wanted finite numbers")
            sections[section].setdefault(entry, []).extend(values)
        elif line:
            entry = line
    return sections
