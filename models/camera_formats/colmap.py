"""COLMAP's `cameras.txt`: one line a camera, `CAMERA_ID MODEL WIDTH HEIGHT PARAMS…`.

Source: COLMAP's output format and `sensor/models.h`. Its centres count from the corner of the first pixel.
"""

from __future__ import annotations

import re

from armtwin.models.camera_formats.calibration import Calibration, pinhole
from armtwin.models.camera_formats.source import Source
from armtwin.models.errors import InputError, nearest

_LINE = re.compile(r"(\d+)\s+([A-Z][A-Z_]+)\s+(\d+)\s+(\d+)((?:\s+[-+.\deE]+)+)\s*$")

# Of each model: the parameters' names in COLMAP's order, and the lens. A single f is both focal lengths.
_MODELS = {
    "SIMPLE_PINHOLE": ("f cx cy", "plumb_bob"),
    "PINHOLE": ("fx fy cx cy", "plumb_bob"),
    "SIMPLE_RADIAL": ("f cx cy k1", "plumb_bob"),
    "RADIAL": ("f cx cy k1 k2", "plumb_bob"),
    "OPENCV": ("fx fy cx cy k1 k2 p1 p2", "plumb_bob"),
    "FULL_OPENCV": ("fx fy cx cy k1 k2 p1 p2 k3 k4 k5 k6", "rational_polynomial"),
    "SIMPLE_RADIAL_FISHEYE": ("f cx cy k1", "equidistant"),
    "RADIAL_FISHEYE": ("f cx cy k1 k2", "equidistant"),
    "OPENCV_FISHEYE": ("fx fy cx cy k1 k2 k3 k4", "equidistant"),
}
_ORDER = {
    "plumb_bob": ("k1", "k2", "p1", "p2", "k3"),
    "rational_polynomial": ("k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"),
    "equidistant": ("k1", "k2", "k3", "k4"),
}
# Pixels from the corner of the first one, where COLMAP counts from, to its centre.
_CENTRE = 0.5


def recognises(source: Source) -> bool:
    """Whether the first line that is no comment is a camera's."""
    return _LINE.match(source.head.partition("\n")[0]) is not None


def read(source: Source) -> Calibration:
    """Read the file's one camera; raises InputError that starts with its number."""
    lines = [line for line in source.head.splitlines() if line.strip() and not line.startswith("#")]
    if len(lines) > 1:
        raise InputError(f"found {len(lines)} cameras, wanted one; keep the line of one")
    found = _LINE.match(lines[0])
    if found is None:  # its caller asked `recognises` first
        raise InputError("found no camera's line")
    number, model, width, height, rest = found.groups()
    if model not in _MODELS:
        raise InputError(
            f"camera {number}: found the model {model}, wanted one of {', '.join(_MODELS)}{nearest(model, _MODELS)}; "
            "run COLMAP again with OPENCV"
        )
    names, lens = _MODELS[model]
    values = rest.split()
    if len(values) != len(names.split()):
        raise InputError(f"camera {number}: found {len(values)} numbers of {model}, wanted {names}")
    try:
        by_name = dict(zip(names.split(), map(float, values), strict=True))
    except ValueError:
        raise InputError(f"camera {number}: found {rest.strip()[:60]!r}, wanted the numbers {names}") from None
    fx, fy = by_name.get("fx", by_name.get("f", 0.0)), by_name.get("fy", by_name.get("f", 0.0))
    return Calibration(
        width=int(width),
        height=int(height),
        K=pinhole(fx, fy, by_name["cx"] - _CENTRE, by_name["cy"] - _CENTRE),
        model=lens,
        coefficients=[by_name.get(name, 0.0) for name in _ORDER[lens]],
        matrix_key=f"camera {number}",
    )
