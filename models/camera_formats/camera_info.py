"""ROS 1 and 2 `camera_info` files (`camera_calibration_parsers`), and armtwin's own, which add the board's pose."""

from __future__ import annotations

from typing import Any

from armtwin.models.camera_formats.calibration import Calibration
from armtwin.models.camera_formats.matrices import block, board_pose, numbers
from armtwin.models.camera_formats.source import Source, the_only
from armtwin.models.errors import InputError

# What other programs call ROS's `equidistant`. image_pipeline writes `camera_model: fisheye` and no distortion model.
_FISHEYE = ("fisheye", "equidistant", "kannala_brandt", "kannala_brandt4")


def recognises(source: Source) -> bool:
    """Whether a document has ROS's keys."""
    return bool(_cameras(source))


def read(source: Source) -> Calibration:
    """Read the file's one camera; raises InputError that starts with the key."""
    content = the_only(_cameras(source))
    R, t = board_pose(content)
    model = _model(content)
    return Calibration(
        width=content.get("image_width"),
        height=content.get("image_height"),
        K=block("camera_matrix", content.get("camera_matrix"), (3, 3)).reshape(3, 3),
        model=model,
        coefficients=_coefficients(content, model).tolist(),
        R=R,
        t=t,
    )


def _cameras(source: Source) -> list[dict[str, Any]]:
    marks = {"distortion_model", "camera_model"}
    return [document for document in source.mappings if marks & set(document)]


def _model(content: dict[str, Any]) -> str:
    lens, camera = (str(content.get(key) or "") for key in ("distortion_model", "camera_model"))
    if lens.lower() in _FISHEYE or (not lens and camera.lower() in _FISHEYE):
        return "equidistant"
    if camera.lower() in _FISHEYE:
        raise InputError(
            f"distortion_model: found {lens!r} beside camera_model {camera!r}, wanted one model; keep the true one"
        )
    if camera and camera.lower() not in ("pinhole", "plumb_bob"):
        raise InputError(f"camera_model: found {camera!r}, wanted pinhole or fisheye; calibrate with one of those")
    return lens or "plumb_bob"


def _coefficients(content: dict[str, Any], model: str) -> Any:
    key = "distortion_coefficients"
    if key not in content:
        raise InputError(f"{key}: found nothing, wanted rows, cols and data; no numbers where there is no distortion")
    found = content[key]
    # image_pipeline writes 5 columns whatever follows (its issue 278).
    if isinstance(found, dict) and found.get("cols") == 5 and found.get("rows") == 1 and model != "plumb_bob":
        return numbers(key, found)
    return numbers(key, found) if found is None else block(key, found)
