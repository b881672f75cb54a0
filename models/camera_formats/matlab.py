"""MATLAB's cameras as text: what it displays of `cameraIntrinsics`, a struct as JSON, and Bouguet's `Calib_Results.m`.

MATLAB counts pixels from 1: its principal point is one more than OpenCV's, in both directions. Its `ImageSize` is rows
by columns, and its older `IntrinsicMatrix` is transposed. Bouguet's toolbox counts from 0; its skew is a share of fx.
"""

from __future__ import annotations

import re
from typing import Any

import numpy as np

from armtwin.models.camera_formats.calibration import Calibration, pinhole
from armtwin.models.camera_formats.matrices import numbers
from armtwin.models.camera_formats.source import Source
from armtwin.models.errors import InputError

_ONE = 1.0  # MATLAB's first pixel
_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
# Characters in which the numbers after a name stand: nine in rows, with blanks.
_LONGEST = 2000
_MATRIX_NAMES = ("K", "IntrinsicMatrix")


def recognises(source: Source) -> bool:
    """Whether MATLAB's or Bouguet's names stand in the text."""
    return "RadialDistortion" in source.text or _is_bouguets(source.text)


def read(source: Source) -> Calibration:
    """Read the camera; raises InputError that starts with the name."""
    if _is_bouguets(source.text):
        return _bouguet(source.text)
    if re.search(r"MappingCoefficients|DistortionCenter", source.text):
        raise InputError(
            "found MATLAB's fisheyeIntrinsics (Scaramuzza's model), wanted cameraIntrinsics; calibrate the pictures "
            "with `armtwin calibrate-camera`, which fits an equidistant lens"
        )
    values = {name: _found(source, name) for name in ("FocalLength", "PrincipalPoint", "ImageSize", "Skew")}
    radial, tangential = _found(source, "RadialDistortion") or [0.0, 0.0], _found(source, "TangentialDistortion")
    matrix = next((m for m in (_found(source, name) for name in _MATRIX_NAMES) if m is not None and len(m) == 9), None)
    focal, centre, skew = values["FocalLength"], values["PrincipalPoint"], values["Skew"] or [0.0]
    if matrix is not None and (focal is None or centre is None):
        K = np.array(matrix).reshape(3, 3)
        K = K if K[2, 0] == 0.0 and K[2, 1] == 0.0 else K.T
        focal, centre, skew = [K[0, 0], K[1, 1]], [K[0, 2], K[1, 2]], [K[0, 1]]
    if focal is None or centre is None or len(focal) != 2 or len(centre) != 2:
        raise InputError(
            "FocalLength and PrincipalPoint: found no two numbers each, wanted what MATLAB displays of "
            "cameraParams.Intrinsics; write that into the file"
        )
    size = values["ImageSize"]
    if size is None or len(size) != 2:
        raise InputError("ImageSize: found nothing, wanted [rows columns]; add the line, such as ImageSize: [720 1280]")
    p = [*(tangential or []), 0.0, 0.0][:2]
    k = [*radial, 0.0, 0.0, 0.0][:3]
    return Calibration(
        width=size[1],
        height=size[0],
        K=pinhole(focal[0], focal[1], centre[0] - _ONE, centre[1] - _ONE, skew[0]),
        model="plumb_bob",
        coefficients=[k[0], k[1], p[0], p[1], k[2]],
        size_keys=("ImageSize", "ImageSize"),
        matrix_key="FocalLength",
    )


def _found(source: Source, name: str) -> list[float] | None:
    """The numbers after a name.

    In a display (`Name: [a b]`), an assignment (`x.Name = [a b; c d];`), rows below the name (`Name =`, with or without
    MATLAB's common factor, `1.0e+03 *`) or JSON.
    """
    if source.head.startswith("{"):
        found = _holder(source).get(name)
        if found is None:
            return None
        return numbers(name, found if isinstance(found, list) else [found]).tolist()
    return _after(rf"\b{name}", source.text)


def _after(name: str, text: str) -> list[float] | None:
    """The numbers after the first place where a name's pattern stands before `:` or `=`; None where there are none."""
    place = re.search(name + r"[ \t]{0,40}[:=]", text)
    if place is None:
        return None
    rest = text[place.end() : place.end() + _LONGEST].lstrip()
    if rest.startswith("["):
        words = re.split(r"[\s,;]+", rest[1:].partition("]")[0].strip())
        listed = [value for value in map(_number, words) if value is not None]
        return listed if len(listed) == len(words) else None
    words = re.split(r"[\s;]+", rest)
    factor = _number(words[0]) if words[1:2] == ["*"] else 1.0
    values = []
    for word in words[2 if words[1:2] == ["*"] else 0 :]:
        value = _number(word)
        if value is None:
            break
        values.append(value * (factor or 1.0))
    return values or None


def _number(word: str) -> float | None:
    return float(word) if re.fullmatch(_NUMBER, word) else None


def _holder(source: Source) -> dict[str, Any]:
    """The structure with the distortion: the whole JSON, or its `Intrinsics`."""
    parts = [part for whole in source.mappings for part in (whole, *whole.values()) if isinstance(part, dict)]
    return next((part for part in parts if "RadialDistortion" in part), {})


def _is_bouguets(text: str) -> bool:
    return re.search(r"(?m:^)[ \t]{0,40}fc[ \t]{0,40}=[ \t]{0,40}\[", text) is not None


def _bouguet(text: str) -> Calibration:
    values = {}
    for name, least in (("fc", 2), ("cc", 2), ("kc", 4), ("nx", 1), ("ny", 1)):
        values[name] = _after(rf"(?m:^)[ \t]{{0,40}}{name}", text) or []
        if len(values[name]) < least:
            raise InputError(f"{name}: found {len(values[name])} numbers, wanted {least} or more as in Calib_Results.m")
    skew = (_after(r"(?m:^)[ \t]{0,40}alpha_c", text) or [0.0])[0]
    (fx, fy), (cx, cy) = values["fc"][:2], values["cc"][:2]
    return Calibration(
        width=values["nx"][0],
        height=values["ny"][0],
        K=pinhole(fx, fy, cx, cy, fx * skew),
        model="plumb_bob",
        coefficients=values["kc"],
        size_keys=("nx", "ny"),
        matrix_key="fc",
    )
