"""How far the tip is from where a model of the arm puts it, in the robot's plane, mm."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armtwin.models.camera import back_project
from armtwin.models.coordinate_frames import board_to_robot
from armtwin.models.errors import InputError
from armtwin.models.kinematics import Deviation, marker_positions
from armtwin.models.recordings.recording import Recording

Array = NDArray[np.float64]


@dataclass(frozen=True)
class TipError:
    """Distances of the measured tip from the predicted one, mm, over n poses."""

    n: int
    mean_mm: float
    rms_mm: float
    median_mm: float
    max_mm: float


def tip_error(
    recording: Recording, rows: NDArray[np.int64], base_in_board_mm: Array, delta: Deviation | None = None
) -> TipError:
    """Compare the measured tip (the last marker) with the commands through the drawing, or through `delta`.

    Raises `InputError` where the tip is not seen in any of `rows`.
    """
    distance = tip_distances(recording, rows, base_in_board_mm, delta)
    distance = distance[np.isfinite(distance)]
    if not len(distance):
        raise InputError(f"samples.csv: marker {recording.arm.marker_names[-1]} is not seen in any pose to validate on")
    return TipError(
        n=len(distance),
        mean_mm=float(distance.mean()),
        rms_mm=float(np.sqrt((distance**2).mean())),
        median_mm=float(np.median(distance)),
        max_mm=float(distance.max()),
    )


def drawn_base_mm(recording: Recording) -> Array:
    """(3,) where the drawing's arm must stand in the board frame to meet what was seen: by marker A, or by all of them.

    What is measured "by the drawing" stands here, and not where a calibrated arm would.
    """
    assert recording.camera is not None
    assert recording.arm_plane_z_mm is not None
    drawn = marker_positions(recording.arm, recording.q_cmd)
    names = [name for name in recording.arm.marker_names if name in recording.markers_px]
    shifts = {}
    for name in names:
        board = back_project(recording.camera, recording.markers_px[name], recording.arm_plane_z_mm)
        robot = board_to_robot(board, np.zeros(3))[:, :2]
        shifts[name] = robot - drawn[:, recording.arm.marker_names.index(name)]
    base = recording.arm.marker_names[0]
    by_base = base in shifts and bool(np.isfinite(shifts[base]).any())
    shift = shifts[base] if by_base else np.concatenate(list(shifts.values()))
    x, y = np.nanmedian(shift, axis=0)
    return np.array([-x, y, recording.arm_plane_z_mm])


def joint_error_rms(recording: Recording, rows: NDArray[np.int64], delta: Deviation | None = None) -> float:
    """Root mean square of measured less predicted joint angles, rad; NaN where none was measured."""
    if recording.q_meas is None:
        return float("nan")
    off = (recording.q_meas - recording.q_cmd)[rows] - (0.0 if delta is None else delta.joints_rad)
    off = off[np.isfinite(off)]
    return float(np.sqrt((off**2).mean())) if len(off) else float("nan")


def tip_distances(
    recording: Recording, rows: NDArray[np.int64], base_in_board_mm: Array, delta: Deviation | None = None
) -> Array:
    """(N,) distances, mm, of the measured tip from the predicted one; NaN where the tip was not seen."""
    tip = recording.arm.marker_names[-1]
    if recording.camera is None or recording.arm_plane_z_mm is None or tip not in recording.markers_px:
        return np.full(len(rows), np.nan)
    board = back_project(recording.camera, recording.markers_px[tip][rows], recording.arm_plane_z_mm)
    predicted = marker_positions(recording.arm, recording.q_cmd[rows], delta)[:, -1]
    distances: Array = np.linalg.norm(board_to_robot(board, base_in_board_mm)[:, :2] - predicted, axis=-1)
    return distances
