"""Where the tip was seen: what the labs' arithmetic starts from."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armtwin.models.camera import back_project
from armtwin.models.recordings.recording import Recording

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Tips:
    """(N, 3) commands `q_cmd`, rad, and (N, 2) places `tip_mm` of the tip against A in the robot frame, mm."""

    q_cmd: Array
    tip_mm: Array

    def __len__(self) -> int:
        return len(self.q_cmd)


def tips_of(recording: Recording, trajectories: list[str]) -> Tips:
    """Return what the camera says of the named trajectories; x_robot is -x_board (equation 12)."""
    rows = np.isin(recording.trajectory, trajectories)
    assert recording.camera is not None
    assert recording.arm_plane_z_mm is not None
    first, last = recording.arm.marker_names[0], recording.arm.marker_names[-1]
    base, tip = (
        back_project(recording.camera, recording.markers_px[name][rows], recording.arm_plane_z_mm)[:, :2]
        for name in (first, last)
    )
    # A does not move: its mean is better than one picture's.
    return Tips(recording.q_cmd[rows], (tip - base.mean(axis=0)) * [-1.0, 1.0])
