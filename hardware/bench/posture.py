"""Where the arm stands, from its markers in one picture."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from armtwin.models.arm import Arm
from armtwin.models.camera import Camera, back_project
from armtwin.models.coordinate_frames import board_to_robot
from armtwin.models.kinematics import complex_links, wrap

Array = NDArray[np.float64]

# Finds the markers in an (H, W, 3) BGR picture of an arm that is thought to stand at about (n,) joint angles, rad,
# which only break ties: raw pixels (2,) by name, unseen markers left out.
FindMarkers = Callable[[NDArray[np.uint8], Array], Mapping[str, Array]]


def link_vectors_mm(
    arm: Arm, camera: Camera, arm_plane_z_mm: float, markers_px: Mapping[str, Array]
) -> NDArray[np.complex128] | None:
    """(n,) each link as the complex number that leads from its marker to the next, robot frame, mm.

    None when a marker on an axis or the tip is not seen.
    """
    if any(name not in markers_px for name in arm.marker_names):
        return None
    pixels = np.stack([np.asarray(markers_px[name], dtype=float) for name in arm.marker_names])
    if not np.isfinite(pixels).all():
        return None
    points = board_to_robot(back_project(camera, pixels, arm_plane_z_mm), np.zeros(3))
    z = points[:, 0] + 1j * points[:, 1]
    return np.diff(z)


def joint_angles(arm: Arm, links_mm: NDArray[np.complex128]) -> Array:
    """(n,) joint angles, rad in (-pi, pi], of the nominal arm whose links point along these (n,) vectors."""
    directions = np.angle(links_mm) - np.angle(complex_links(arm))
    return wrap(np.diff(directions, prepend=0.0) - arm.zero_pose_rad)
