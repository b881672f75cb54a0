"""OpenCV's `FileStorage` in YAML, XML and JSON, with the keys that its samples and tutorials have used over the years.

`camera_matrix` and `image_width` (samples since 1.0, and 3.0 on), `Camera_Matrix` and `image_Width` (2.x),
`cameraMatrix` and `distCoeffs` (ArUco samples, many programs), `mtx` and `dist` (the Python tutorial).
"""

from __future__ import annotations

from typing import Any

from armtwin.models.camera_formats.calibration import Calibration
from armtwin.models.camera_formats.matrices import block, board_pose, numbers
from armtwin.models.camera_formats.source import Source, the_only
from armtwin.models.errors import InputError

# Keys without underscores, in small letters.
_MATRIX = ("cameramatrix", "intrinsicmatrix", "intrinsics", "mtx", "k")
_DISTORTION = (
    "distortioncoefficients",
    "distcoeffs",
    "distcoeff",
    "distcoefs",
    "distortioncoeff",
    "distortion",
    "dist",
    "d",
)
_WIDTH, _HEIGHT = ("imagewidth", "width", "framewidth"), ("imageheight", "height", "frameheight")
_SIZE = ("imagesize", "resolution", "size")
# The first camera of OpenCV's stereo samples, old and new.
_STEREO = ("M1", "K1")
_FISHEYE = ("fisheyemodel", "fisheye")


def recognises(source: Source) -> bool:
    """Whether a document has a camera matrix under one of the keys."""
    return bool(_cameras(source))


def read(source: Source) -> Calibration:
    """Read the file's one camera; raises InputError that starts with the key."""
    content = the_only(_cameras(source))
    first = next((name for name in _STEREO if name in content), None)
    if first is not None:
        raise InputError(
            f"found the stereo cameras {first} and {first[0]}2, wanted one; copy its matrices into a file of its own "
            "as camera_matrix and distortion_coefficients"
        )
    matrix, distortion = _key(content, _MATRIX) or "", _key(content, _DISTORTION)
    if distortion is None:
        raise InputError(
            "distortion_coefficients: found nothing, wanted the lens's numbers, or [] where it has no distortion"
        )
    R, t = board_pose(content)
    width, height, size_keys = _size(content)
    fisheye = _key(content, _FISHEYE)
    return Calibration(
        width=width,
        height=height,
        K=block(matrix, content[matrix], (3, 3)).reshape(3, 3),
        model="equidistant" if fisheye is not None and content[fisheye] else "plumb_bob",
        coefficients=block(distortion, content[distortion]).tolist(),
        R=R,
        t=t,
        size_keys=size_keys,
        matrix_key=matrix,
    )


def _cameras(source: Source) -> list[dict[str, Any]]:
    return [document for document in source.mappings if _key(document, _MATRIX) or set(_STEREO) & set(document)]


def _size(content: dict[str, Any]) -> tuple[object, object, tuple[str, str]]:
    size = _key(content, _SIZE)
    if size is not None:
        both = numbers(size, content[size]).tolist()
        if len(both) == 2:
            return both[0], both[1], (size, size)
    width, height = _key(content, _WIDTH), _key(content, _HEIGHT)
    keys = (width or "image_width", height or "image_height")
    return content.get(keys[0]), content.get(keys[1]), keys


def _key(content: dict[str, Any], names: tuple[str, ...]) -> str | None:
    """The document's own spelling of one of the names, the first of them that it has."""
    spelt = {str(key).replace("_", "").replace("-", "").lower(): str(key) for key in content if isinstance(key, str)}
    return next((spelt[name] for name in names if name in spelt), None)
