"""The markers of one picture, as the bench asks for them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from armtwin.calib.markers.detect import detect
from armtwin.calib.markers.identify import identify
from armtwin.hardware.bench.posture import FindMarkers
from armtwin.models.arm import Arm
from armtwin.models.camera import Camera

Array = NDArray[np.float64]


def marker_finder(arm: Arm, camera: Camera, plane_z_mm: float) -> FindMarkers:
    """Return what finds the markers of `arm` in a picture, see `armtwin.hardware.bench.posture.FindMarkers`."""

    def find(image: NDArray[np.uint8], q: Array) -> dict[str, Array]:
        discs = detect(image, camera=camera, plane_z_mm=plane_z_mm)
        reading = identify(discs, arm, camera, plane_z_mm, q_cmd=q)
        return {name: disc.centre for name, disc in reading.discs.items()}

    return find
