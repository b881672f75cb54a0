"""How far a recording lies from its drawing when only what calibration may change is free: zeros, lengths, the base.

Angles: measured = commanded + a zero a joint. Markers, in the arm's plane: marker = base + sum c_i exp(j Theta_i),
which is linear in the base and in the complex links c_i (see `calib.arm.start`). Both by medians or reweighting, so
that up to a third of wrong rows does not carry them away.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armtwin.models.camera import back_project
from armtwin.models.kinematics import along_path, complex_links, wrap
from armtwin.models.recordings.recording import Recording
from armtwin.models.statistics import MAD_TO_STD

Array = NDArray[np.float64]

_REWEIGHTINGS = 15
# Distances below this count alike, mm: a good detector's noise.
_SMALL_MM = 0.05
# The drawing holds what the poses leave open, mm: far wider than any arm is off.
_DRAWN_MM = 300.0


@dataclass(frozen=True, eq=False)
class Remainder:
    """What the drawing leaves of a recording, at best.

    Attributes:
        errors: (N, M) distance of each channel from its prediction, rad for angles and mm for markers; NaN unseen.
        links: (n,) complex links as the poses have them over the drawn ones: modulus the lengths' ratio, argument the
            sum of the joint zeros up to it; ones for angles.
        zeros_rad: (n,) zero of each joint.

    """

    errors: Array
    links: NDArray[np.complex128]
    zeros_rad: Array

    def spreads(self, rows: NDArray[np.bool_]) -> Array:
        """(M,) typical distance of each channel over rows (N,), by medians; 0 where it is not seen."""
        seen = [column[np.isfinite(column)] for column in self.errors[rows].T]
        return np.array([MAD_TO_STD * np.median(values) if len(values) else 0.0 for values in seen])


def remainder_of(recording: Recording) -> Remainder:
    """Return what the drawing leaves of a recording."""
    if any(np.isfinite(pixels).any() for pixels in recording.markers_px.values()):
        return _of_markers(recording)
    assert recording.q_meas is not None
    error = recording.q_meas - recording.q_cmd
    zeros = np.nanmedian(error, axis=0)
    return Remainder(np.abs(error - zeros), np.ones(error.shape[1], dtype=complex), zeros)


def _of_markers(recording: Recording) -> Remainder:
    assert recording.camera is not None
    assert recording.arm_plane_z_mm is not None
    arm = recording.arm
    names = [name for name in arm.marker_names if name in recording.markers_px]
    headings = np.exp(1j * np.cumsum(recording.q_cmd + arm.zero_pose_rad, axis=1))
    drawn = complex_links(arm)
    blocks, targets = [], []
    for name in names:
        links = along_path(arm, headings, name)[:, : arm.n_joints]
        seen = back_project(recording.camera, recording.markers_px[name], recording.arm_plane_z_mm)
        blocks.append(np.concatenate([np.ones((len(headings), 1)), links * drawn], axis=1))
        targets.append(-seen[:, 0] + 1j * seen[:, 1])  # x_robot is -x_board
    A, w = np.stack(blocks, axis=1), np.stack(targets, axis=1)
    solution = _reweighted(A.reshape(-1, A.shape[-1]), w.ravel(), np.abs(drawn))
    errors = np.abs(w - A @ solution)
    turns = np.angle(solution[1:])
    return Remainder(errors, solution[1:], wrap(np.diff(turns, prepend=0.0)))


def _reweighted(A: NDArray[np.complex128], w: NDArray[np.complex128], drawn_mm: Array) -> NDArray[np.complex128]:
    """Least absolute distances by reweighting; the links start, and weakly stay, as drawn."""
    finite = np.isfinite(w)
    A, w = A[finite], w[finite]
    prior = np.diag(np.concatenate([[0.0], (_SMALL_MM / _DRAWN_MM) ** 2 * drawn_mm**2 + 1e-12]))
    pull = prior @ np.ones(A.shape[1])
    weight = np.ones(len(w))
    solution = np.ones(A.shape[1], dtype=complex)
    for _ in range(_REWEIGHTINGS):
        weighted = A.conj().T * weight
        solution = np.linalg.solve(weighted @ A + prior, weighted @ w + pull)
        weight = _SMALL_MM / np.maximum(np.abs(w - A @ solution), _SMALL_MM)
    return solution
