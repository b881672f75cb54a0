"""The markers of one picture, as the bench asks for them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from calib.markers.detect import detect
from calib.markers.identify import identify
from hardware.posture import FindMarkers
from models.arm import Arm
from models.camera import Camera

Array = NDArray[np.float64]


def marker_finder(arm: Arm, camera: Camera, plane_z_mm: float) -> FindMarkers:
    """Return a function from an (H, W, 3) BGR picture to the raw pixels (2,) of the markers that are seen, by name."""

    def find(image: NDArray[np.uint8]) -> dict[str, Array]:
        reading = identify(detect(image, camera=camera, plane_z_mm=plane_z_mm), arm, camera, plane_z_mm)
        return {name: disc.centre for name, disc in reading.discs.items()}

    return find
