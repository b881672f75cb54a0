"""The door to both detectors: what it refuses."""

from __future__ import annotations

import numpy as np
import pytest

from armtwin.calib.markers import detect
from armtwin.models.camera import Camera
from armtwin.models.errors import InputError


def test_a_picture_of_another_size_than_the_camera_s_is_refused(webcam: Camera) -> None:
    with pytest.raises(InputError, match="picture: 640x480 px, the camera was calibrated at 1280x720"):
        detect(np.zeros((480, 640, 3), np.uint8), camera=webcam)


def test_an_unknown_method_is_refused_with_the_nearest_name() -> None:
    with pytest.raises(InputError, match="unknown 'subpixels'; did you mean 'subpixel'"):
        detect(np.zeros((48, 64, 3), np.uint8), "subpixels")  # type: ignore[arg-type]
