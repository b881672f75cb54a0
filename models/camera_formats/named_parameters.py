"""Cameras given number by number: camodocal (VINS), ORB-SLAM 2 and 3, the RealSense SDK's intrinsics, nerfstudio.

Focal lengths and centre have names there instead of a matrix. Sources: camodocal's `CameraFactory`; ORB-SLAM3's
calibration tutorial, 1.0; librealsense `doc/projection.md` (the first pixel's centre at 0, 0); nerfstudio's data
conventions, whose centres are COLMAP's (first pixel's at 0.5, 0.5).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from armtwin.models.camera_formats.calibration import Calibration, pinhole
from armtwin.models.camera_formats.matrices import numbers
from armtwin.models.camera_formats.source import Source, the_only
from armtwin.models.errors import InputError

# What each program calls a focal length, a centre and a size: the first that a file has is meant.
_NAMES = {
    "fx": ("fx", "fl_x", "mu"),
    "fy": ("fy", "fl_y", "mv"),
    "cx": ("cx", "ppx", "u0"),
    "cy": ("cy", "ppy", "v0"),
    "width": ("image_width", "width", "w"),
    "height": ("image_height", "height", "h"),
}
_SECTIONS = ("projection_parameters", "distortion_parameters")
_MODEL_KEYS = ("model_type", "type", "camera_model", "model")
# What the programs call the lenses that are held here, in small letters.
_PLUMB_BOB = ("pinhole", "opencv", "full_opencv", "simple_pinhole", "brown_conrady", "none", "")
_EQUIDISTANT = ("kannala_brandt", "kannalabrandt8", "opencv_fisheye", "kannala_brandt4")
# Lenses of a RealSense that are no lens of OpenCV's unless all their numbers are zero.
_OTHER_BROWN_CONRADY = ("inverse_brown_conrady", "modified_brown_conrady")


def recognises(source: Source) -> bool:
    """Whether a document names a focal length and a centre each for itself."""
    return bool(_cameras(source))


def read(source: Source) -> Calibration:
    """Read the file's one camera; raises InputError that starts with the key."""
    content = the_only(_cameras(source))
    spelt = {_bare(key): key for key in content}
    found = {name: next((spelt[word] for word in words if word in spelt), "") for name, words in _NAMES.items()}
    fx, fy, cx, cy = (
        float(numbers(key, [content[key]])[0]) for key in map(found.__getitem__, ("fx", "fy", "cx", "cy"))
    )
    shift = 0.5 if "fl_x" in spelt else 0.0  # COLMAP's origin is the first pixel's corner
    model = _model(content, spelt)
    return Calibration(
        width=content.get(found["width"]),
        height=content.get(found["height"]),
        K=pinhole(fx, fy, cx - shift, cy - shift),
        model=model,
        coefficients=_coefficients(content, spelt, model),
        size_keys=(found["width"] or "image_width", found["height"] or "image_height"),
        matrix_key=f"{found['fx']} and {found['fy']}",
    )


def _cameras(source: Source) -> list[dict[str, Any]]:
    flat = [_flat(document) for document in source.mappings]
    return [content for content in flat if all(_has(content, name) for name in ("fx", "fy", "cx", "cy"))]


def _flat(document: dict[str, Any]) -> dict[str, Any]:
    """One level of keys: camodocal keeps its numbers in two sections."""
    parts = [document[key] for key in _SECTIONS if isinstance(document.get(key), dict)]
    return {str(key): value for part in (document, *parts) for key, value in part.items()}


def _has(content: dict[str, Any], name: str) -> bool:
    return bool({_bare(key) for key in content} & set(_NAMES[name]))


def _bare(key: str) -> str:
    """A key without the `Camera.` or `Camera1.` that ORB-SLAM puts before it, in small letters."""
    head, dot, tail = key.partition(".")
    return (tail if dot and head in ("Camera", "Camera1") else key).lower()


def _model(content: dict[str, Any], spelt: dict[str, str]) -> str:
    key = next((spelt[word] for word in _MODEL_KEYS if word in spelt), "")
    stated = str(content.get(key) or "").lower().removeprefix("distortion.").replace(" ", "_")
    if stated in _EQUIDISTANT:
        return "equidistant"
    if stated in _OTHER_BROWN_CONRADY:
        if any(numbers("coeffs", content.get("coeffs"))):
            raise InputError(
                f"{key}: found {stated}, which is none of OpenCV's lenses, wanted brown_conrady or numbers that are "
                "all zero; photograph a chessboard and run `armtwin calibrate-camera`"
            )
        return "plumb_bob"
    if stated not in _PLUMB_BOB:
        raise InputError(
            f"{key}: found {content[key]!r}, wanted a pinhole camera with OpenCV's distortion or a Kannala-Brandt "
            "lens; calibrate with one of those"
        )
    return "plumb_bob"


def _coefficients(content: dict[str, Any], spelt: dict[str, str], model: str) -> list[float]:
    if "coeffs" in spelt:
        return [float(number) for number in numbers("coeffs", content[spelt["coeffs"]])]
    # camodocal counts a Kannala-Brandt lens's numbers by their power's place, from k2 on.
    fisheye = "k2 k3 k4 k5" if "mu" in spelt else "k1 k2 k3 k4"
    names = (fisheye if model == "equidistant" else "k1 k2 p1 p2 k3 k4 k5 k6").split()
    values = np.array(
        [float(numbers(spelt[name], [content[spelt[name]]])[0]) if name in spelt else 0.0 for name in names]
    )
    return [float(value) for value in (values if model == "equidistant" or values[5:].any() else values[:5])]
