"""Which format a file is in: each is asked in turn, those with the plainest marks first."""

from __future__ import annotations

from pathlib import Path

from armtwin.models.camera import Camera
from armtwin.models.camera_formats import (
    camera_info,
    camera_info_message,
    kalibr,
    matlab,
    mrcal,
    opencv,
    videre_ini,
)
from armtwin.models.camera_formats.source import read_source
from armtwin.models.errors import InputError

_FORMATS = (mrcal, matlab, videre_ini, kalibr, camera_info_message, camera_info, opencv)


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
        keys = [str(key) for document in source.mappings for key in document]
        found = f"the keys {', '.join(keys[:6])}" if keys else "no keys"
        raise InputError(
            f"camera_matrix: found {found[:200]}, wanted a camera file: keys such as image_width, image_height, "
            "camera_matrix and distortion_coefficients (ROS, OpenCV), or a file of Kalibr, mrcal or MATLAB"
        )
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
