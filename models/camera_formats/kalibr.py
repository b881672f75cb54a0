"""Kalibr's camera chains (`camchain.yaml`): https://github.com/ethz-asl/kalibr/wiki/yaml-formats."""

from __future__ import annotations

from typing import Any

from armtwin.models.camera_formats.calibration import Calibration, pinhole
from armtwin.models.camera_formats.matrices import numbers
from armtwin.models.camera_formats.source import Source
from armtwin.models.errors import InputError, nearest

# Kalibr's names of lenses, and ROS's.
_MODELS = {"radtan": "plumb_bob", "equidistant": "equidistant", "none": "none"}


def recognises(source: Source) -> bool:
    """Whether a document, or a part of one, has Kalibr's list of intrinsics."""
    return any(_cameras(document) for document in source.mappings)


def read(source: Source) -> Calibration:
    """Read the chain's one camera; raises InputError that starts with the key."""
    cameras = next(found for found in map(_cameras, source.mappings) if found)
    if len(cameras) > 1:
        raise InputError(f"found the cameras {', '.join(cameras)}, wanted one; copy its part into a file of its own")
    name, content = next(iter(cameras.items()))
    at = f"{name}: " if name else ""
    camera_model, lens_model = (content.get(key) for key in ("camera_model", "distortion_model"))
    if camera_model != "pinhole":
        raise InputError(
            f"{at}camera_model: found {camera_model!r}, wanted 'pinhole' (omni, ds and eucm are not held here); "
            "calibrate with pinhole-equi for a wide lens"
        )
    if str(lens_model) not in _MODELS:
        raise InputError(
            f"{at}distortion_model: found {lens_model!r}, wanted one of {', '.join(_MODELS)}"
            f"{nearest(str(lens_model), _MODELS)}; calibrate with one of those"
        )
    intrinsics = numbers(f"{at}intrinsics", content.get("intrinsics"))
    resolution = numbers(f"{at}resolution", content.get("resolution")).tolist()
    if intrinsics.size != 4 or len(resolution) != 2:
        raise InputError(
            f"{at}intrinsics: found {intrinsics.size} numbers and {len(resolution)} of resolution, wanted "
            "[fu, fv, pu, pv] and [width, height]"
        )
    return Calibration(
        width=resolution[0],
        height=resolution[1],
        K=pinhole(*intrinsics),
        model=_MODELS[str(lens_model)],
        coefficients=numbers(f"{at}distortion_coeffs", content.get("distortion_coeffs")).tolist(),
        size_keys=(f"{at}resolution", f"{at}resolution"),
        matrix_key=f"{at}intrinsics",
    )


def _cameras(document: dict[str, Any]) -> dict[str, dict[str, Any]]:
    parts = {"": document, **{str(k): v for k, v in document.items() if isinstance(v, dict)}}
    # Basalt's `intrinsics` are lists of cameras.
    return {
        name: part
        for name, part in parts.items()
        if isinstance(part, dict) and "intrinsics" in part and not _holds_mappings(part["intrinsics"])
    }


def _holds_mappings(found: Any) -> bool:
    return isinstance(found, list) and any(isinstance(item, dict) for item in found)
