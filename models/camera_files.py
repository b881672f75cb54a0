"""Camera files: ROS `camera_info` YAML (`.yaml`) and OpenCV's own YAML (`.yml`), read and written.

Both hold the intrinsics and the plumb-bob distortion k1, k2, p1, p2, k3. Two keys of armtwin's own, which other readers
skip, hold the pose of the board: `board_to_camera_rotation` (3x3) and `board_to_camera_translation_mm` (3x1), with
`X_camera = R X_board + t`. Where they are absent the board stands at the camera (identity, zero).
Sources: ROS `camera_calibration_parsers`; OpenCV `FileStorage`. Numbers are written so that they read back exactly.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray

from armtwin.models.atomic import write_text
from armtwin.models.camera import Camera
from armtwin.models.errors import InputError
from armtwin.models.lenses import Lens, lens_named
from armtwin.models.yaml_loader import CameraLoader

Array = NDArray[np.float64]

# A camera file has about 1 kB; OpenCV's calibration samples with all their corner points stay below this.
MAX_FILE_BYTES = 4 * 1024 * 1024
# No sensor is larger; a bound keeps a typing error from making a picture that fills the memory.
MAX_IMAGE_PX = 65536
# How far R Rᵀ may be from identity, per element: written numbers are exact, so this allows for seven printed digits.
ROTATION_TOLERANCE = 1e-6

_OPENCV_HEAD = "%YAML:1.0"
_NOMINAL_WEBCAM = Path(__file__).parent / "nominal" / "webcam.yaml"


def nominal_camera() -> Camera:
    """Return the paper's webcam (Table 2), 1280x720."""
    return read_camera(_NOMINAL_WEBCAM)


def read_camera(path: Path) -> Camera:
    """Read a camera from a ROS `camera_info` or an OpenCV YAML file, told apart by their content.

    Raises:
        InputError: the file is missing, too large, no YAML, or a key is missing or wrong; the message names the key.

    """
    content = _load(path)
    width, height = (_size(path, content, key) for key in ("image_width", "image_height"))
    K = _matrix(path, content, "camera_matrix", (3, 3))
    if not (K[0, 0] > 0 and K[1, 1] > 0 and K[1, 0] == 0 and np.array_equal(K[2], [0, 0, 1])):
        raise InputError(
            f"{path}: camera_matrix: found {K.tolist()}, wanted [[f_x, s, c_x], [0, f_y, c_y], [0, 0, 1]] "
            "with focal lengths above 0 px, row by row"
        )
    R, t = np.eye(3), np.zeros(3)
    if "board_to_camera_rotation" in content or "board_to_camera_translation_mm" in content:
        R = _matrix(path, content, "board_to_camera_rotation", (3, 3))
        t = _matrix(path, content, "board_to_camera_translation_mm", (3, 1)).ravel()
        _check_rotation(path, R)
    return Camera(width, height, K, _lens(path, content), R, t)


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
        f"distortion_model: {camera.lens.model}",
        *_block("distortion_coefficients", camera.lens.coefficients.reshape(1, -1)),
        *_block("rectification_matrix", np.eye(3)),
        *_block("projection_matrix", P),
        *_block("board_to_camera_rotation", camera.R_board_camera),
        *_block("board_to_camera_translation_mm", camera.t_board_camera_mm.reshape(3, 1)),
    ]


def _opencv_lines(camera: Camera, name: str) -> list[str]:
    return [
        *_head(camera, name),
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


def _load(path: Path) -> dict[str, Any]:
    try:
        with path.open("rb") as stream:
            raw = stream.read(MAX_FILE_BYTES + 1)
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror}); wanted a camera file in YAML") from error
    if len(raw) > MAX_FILE_BYTES:
        raise InputError(f"{path}: found more than {MAX_FILE_BYTES} bytes, wanted a camera file in YAML (about 1 kB)")
    try:
        text = raw.decode("utf-8-sig")
        if text.startswith(_OPENCV_HEAD):  # a directive that no YAML library but OpenCV's accepts
            text = text.partition("\n")[2]
        content = yaml.load(text, Loader=CameraLoader)  # noqa: S506 (a subclass of the safe loader)
    except (yaml.YAMLError, ValueError, RecursionError) as error:
        reason = " ".join(str(error).split())[:200]
        raise InputError(f"{path}: found no valid YAML ({reason}), wanted a camera file") from error
    if not isinstance(content, dict):
        raise InputError(f"{path}: found a {type(content).__name__}, wanted keys such as image_width and camera_matrix")
    return content


def _size(path: Path, content: dict[str, Any], key: str) -> int:
    value = content.get(key)
    if isinstance(value, bool) or not isinstance(value, int) or not 1 <= value <= MAX_IMAGE_PX:
        raise InputError(f"{path}: {key}: found {value!r}, wanted whole pixels from 1 to {MAX_IMAGE_PX}")
    return value


def _lens(path: Path, content: dict[str, Any]) -> Lens:
    coefficients = _matrix(path, content, "distortion_coefficients", None).ravel()
    try:
        return lens_named(str(content.get("distortion_model", "plumb_bob")), coefficients)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def _matrix(path: Path, content: dict[str, Any], key: str, shape: tuple[int, int] | None) -> Array:
    block = content.get(key)
    if block is None:
        raise InputError(f"{path}: {key}: found nothing, wanted rows, cols and data")
    if not isinstance(block, dict) or not isinstance(block.get("data"), list):
        raise InputError(f"{path}: {key}: found {type(block).__name__}, wanted rows, cols and data")
    rows, cols = block.get("rows"), block.get("cols")
    if not (isinstance(rows, int) and isinstance(cols, int) and rows > 0 and cols > 0):
        raise InputError(f"{path}: {key}: found rows {rows!r} and cols {cols!r}, wanted whole numbers above 0")
    if shape is not None and (rows, cols) != shape:
        raise InputError(f"{path}: {key}: found {rows} rows and {cols} cols, wanted {shape[0]} and {shape[1]}")
    data = block["data"]
    if any(isinstance(item, bool) or not isinstance(item, (int, float)) for item in data):
        bad = next(item for item in data if isinstance(item, bool) or not isinstance(item, (int, float)))
        raise InputError(f"{path}: {key}: found {str(bad)[:40]!r} in data, wanted numbers")
    try:
        values = np.array(data, dtype=float)
    except OverflowError as error:
        raise InputError(f"{path}: {key}: found a number too large in data, wanted finite numbers") from error
    if not np.all(np.isfinite(values)):
        raise InputError(f"{path}: {key}: found a number that is not finite in data, wanted finite numbers")
    if values.size != rows * cols:
        raise InputError(f"{path}: {key}: found {values.size} numbers in data, wanted rows x cols = {rows} x {cols}")
    return values.reshape(rows, cols)


def _check_rotation(path: Path, R: Array) -> None:
    error = float(np.abs(R @ R.T - np.eye(3)).max())
    if not (error < ROTATION_TOLERANCE and np.linalg.det(R) > 0):
        raise InputError(
            f"{path}: board_to_camera_rotation: found a matrix {error:.1g} away from a rotation "
            f"(determinant {np.linalg.det(R):.3g}), wanted an orthonormal one to {ROTATION_TOLERANCE:g}; "
            "give more digits or re-orthonormalise it"
        )
