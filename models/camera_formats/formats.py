"""Which format a file is in: each is asked in turn, those with the plainest marks first."""

from __future__ import annotations

from pathlib import Path

from armtwin.models.camera import Camera
from armtwin.models.camera_formats import (
    camera_info,
    camera_info_message,
    colmap,
    kalibr,
    matlab,
    mrcal,
    named_parameters,
    opencv,
    videre_ini,
)
from armtwin.models.camera_formats.source import read_source
from armtwin.models.errors import InputError

_FORMATS = (
    mrcal,
    matlab,
    videre_ini,
    colmap,
    kalibr,
    camera_info_message,
    named_parameters,
    camera_info,
    opencv,
)
# Programs whose files are known by a key and not held here: what each is, and the way to a file that is.
_OTHERS = {
    "cameraData": "a calibration of DepthAI's; copy one camera's intrinsicMatrix, distortionCoeff, width and height "
    "into a file of its own",
    "Calibration": "a file of calib.io's; export it for OpenCV",
    "projection": "a calibration of Metashape's; save it as OpenCV's (Tools > Camera Calibration)",
    "value0": "a calibration of Basalt's; calibrate with Kalibr or OpenCV",
}


def read_calibration(path: Path) -> Camera:
    """Read a camera from a file of any known format, told by its content.

    Raises:
        InputError: the file cannot be read, is of no known format, or holds no camera; starts with the path.

    """
    source = read_source(path)
    try:
        for form in _FORMATS:
            if form.recognises(source):
                return form.read(source).camera()
        for document in source.mappings:
            for key in _OTHERS.keys() & document.keys():
                raise InputError(f"{key}: found {_OTHERS[key]}")
        keys = [str(key) for document in source.mappings for key in document]
        found = f"the keys {', '.join(keys[:6])}" if keys else "no keys"
        raise InputError(
            f"camera_matrix: found {found[:200]}, wanted a camera file: keys such as image_width, image_height, "
            "camera_matrix and distortion_coefficients (ROS, OpenCV), or a file of Kalibr, mrcal, MATLAB, COLMAP, "
            "ORB-SLAM, VINS, RealSense or NumPy"
        )
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
