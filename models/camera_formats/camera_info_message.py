"""`sensor_msgs/CameraInfo` messages as `ros2 topic echo` (d, k) and `rostopic echo` (D, K) print them."""

from __future__ import annotations

from typing import Any

from armtwin.models.camera_formats.calibration import Calibration
from armtwin.models.camera_formats.matrices import block, board_pose, numbers
from armtwin.models.camera_formats.source import Source
from armtwin.models.errors import InputError


def recognises(source: Source) -> bool:
    """Whether a document has a message's keys."""
    return any(_is_message(document) for document in source.mappings)


def read(source: Source) -> Calibration:
    """Read the camera that all messages state; raises InputError where they differ, or where pictures are cut."""
    messages = [document for document in source.mappings if _is_message(document)]
    stated = [_stated(message) for message in messages]
    if any(one != stated[0] for one in stated):
        raise InputError(f"found {len(stated)} messages of different cameras, wanted one camera; keep its messages")
    content, k = messages[0], _key(messages[0], "k")
    for axis in ("binning_x", "binning_y"):
        if content.get(axis, 0) not in (0, 1):
            raise InputError(
                f"{axis}: found {content[axis]!r}, wanted 0 or 1; calibrate with the pictures as they come, binned"
            )
    roi = content.get("roi")
    if isinstance(roi, dict) and (roi.get("x_offset") or roi.get("y_offset")):
        raise InputError("roi: found a picture cut out of the sensor's, wanted it whole; calibrate with it as it comes")
    R, t = board_pose(content)
    return Calibration(
        width=content.get("width"),
        height=content.get("height"),
        K=block(k, content[k], (3, 3)).reshape(3, 3),
        model=str(content.get("distortion_model") or ""),
        coefficients=numbers(_key(content, "d"), content.get(_key(content, "d"))).tolist(),
        R=R,
        t=t,
        size_keys=("width", "height"),
        matrix_key=k,
    )


def _is_message(document: dict[str, Any]) -> bool:
    return "width" in document and ("k" in document or "K" in document)


def _key(message: dict[str, Any], name: str) -> str:
    return name if name in message else name.upper()


def _stated(message: dict[str, Any]) -> list[str]:
    keys = ("width", "height", "distortion_model", "k", "K", "d", "D")
    return [repr(message.get(key)) for key in keys]
