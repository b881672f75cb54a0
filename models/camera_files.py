"""Camera files: every known format is read (`models/camera_formats`), ROS's and OpenCV's YAML are written.

Both hold the intrinsics and the lens. Two keys of armtwin's own, which other readers skip, hold the pose of the board:
`board_to_camera_rotation` (3x3) and `board_to_camera_translation_mm` (3x1), with `X_camera = R X_board + t`. Where they
are absent the board stands at the camera (identity, zero).
Sources: ROS `camera_calibration_parsers`; OpenCV `FileStorage`. Numbers are written so that they read back exactly.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import yaml
from numpy.typing import NDArray

from armtwin.models.atomic import write_text
from armtwin.models.camera import Camera
from armtwin.models.camera_formats import read_calibration
from armtwin.models.camera_formats.source import MAX_FILE_BYTES
from armtwin.models.errors import InputError
from armtwin.models.lenses import Equidistant

__all__ = ["MAX_FILE_BYTES", "nominal_camera", "read_camera", "write_camera"]

Array = NDArray[np.float64]

_OPENCV_HEAD = "%YAML:1.0"
_NOMINAL_WEBCAM = Path(__file__).parent / "nominal" / "webcam.yaml"


def nominal_camera() -> Camera:
    """Return the paper's webcam (Table 2), 1280x720."""
    return read_camera(_NOMINAL_WEBCAM)


def read_camera(path: Path) -> Camera:
    """Read a camera from a file of any format of `models/camera_formats`, told by its content.

    Raises:
        InputError: the file is missing, too large, of no known format, or a key is missing or wrong; the message names
            the key.

    """
    return read_calibration(path)


def write_camera(path: Path, camera: Camera, name: str = "camera", comment: str = "") -> None:
    """Write a camera atomically: `.yaml` as ROS `camera_info`, `.yml` as OpenCV YAML.

    `comment` becomes the head of the file, line by line.

    Raises:
        InputError: another suffix.

    """
    if path.suffix not in (".yaml", ".yml"):
        raise InputError(f"{path}: found the suffix {path.suffix!r}, wanted .yaml (ROS camera_info) or .yml (OpenCV)")
    # YAML refuses control characters even in comments, and file names, which comments quote, may hold any.
    plain = ("".join(c if c.isprintable() else "?" for c in line) for line in comment.splitlines())
    lines = [f"# {line}".rstrip() for line in plain]
    body = _ros_lines(camera, name) if path.suffix == ".yaml" else _opencv_lines(camera, name)
    head = [] if path.suffix == ".yaml" else [_OPENCV_HEAD, "---"]
    write_text(path, "\n".join(head + lines + body) + "\n")


def _ros_lines(camera: Camera, name: str) -> list[str]:
    P = np.hstack([camera.K, np.zeros((3, 1))])
    return [
        *_head(camera, name),
        *_block("camera_matrix", camera.K),
        f"distortion_model: {camera.lens.ros_model}",
        *_block("distortion_coefficients", camera.lens.coefficients.reshape(1, -1)),
        *_block("rectification_matrix", np.eye(3)),
        *_block("projection_matrix", P),
        *_block("board_to_camera_rotation", camera.R_board_camera),
        *_block("board_to_camera_translation_mm", camera.t_board_camera_mm.reshape(3, 1)),
    ]


def _opencv_lines(camera: Camera, name: str) -> list[str]:
    return [
        *_head(camera, name),
        *(["fisheye_model: 1"] if isinstance(camera.lens, Equidistant) else []),
        *_block("camera_matrix", camera.K, opencv=True),
        *_block("distortion_coefficients", camera.lens.coefficients.reshape(-1, 1), opencv=True),
        *_block("board_to_camera_rotation", camera.R_board_camera, opencv=True),
        *_block("board_to_camera_translation_mm", camera.t_board_camera_mm.reshape(3, 1), opencv=True),
    ]


def _head(camera: Camera, name: str) -> list[str]:
    # YAML's own quoting: a name may hold a colon or a line break.
    quoted = yaml.safe_dump(name, default_style='"', width=float("inf")).strip()
    return [
        f"image_width: {int(camera.image_width)}",
        f"image_height: {int(camera.image_height)}",
        f"camera_name: {quoted}",
    ]


def _block(key: str, matrix: Array, opencv: bool = False) -> list[str]:
    rows, cols = matrix.shape
    numbers = ", ".join(_number(value) for value in matrix.ravel())
    tag, kind = (" !!opencv-matrix", ["   dt: d"]) if opencv else ("", [])
    return [f"{key}:{tag}", f"   rows: {rows}", f"   cols: {cols}", *kind, f"   data: [{numbers}]"]


def _number(value: float) -> str:
    """Shortest text that reads back as the same float, with the dot that YAML 1.1 wants of a float."""
    text = repr(float(value))
    mantissa, e, exponent = text.partition("e")
    return text if "." in mantissa or not e else f"{mantissa}.0e{exponent}"
