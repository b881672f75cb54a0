"""A robust starting point: the chain's coefficients by weighted linear least squares in the arm's plane."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from armtwin.calib.arm.chain import LENGTH_SPREAD_MM, Chain
from armtwin.calib.arm.observations import Observations
from armtwin.models.camera import Camera, back_project
from armtwin.models.errors import InputError
from armtwin.models.kinematics import wrap

Array = NDArray[np.float64]

# Iterations of reweighting towards least absolute distances, which up to half of gross errors do not carry away.
_REWEIGHTINGS = 12
# Distances below this count alike, mm: about the pixel noise of a good detector.
_SMALL_MM = 0.05


def start(chain: Chain, observations: Observations, camera: Camera, arm_plane_z_mm: float) -> Array:
    """(P + 2,) link parameters and base_x, base_y in the board frame, mm and rad, from K markers' pixels.

    Marker = base + sum c_i exp(j Theta_i) is linear in base and c. The drawing's coefficients with their spread are
    added as weak observations, so that what the poses leave open stays as drawn. E is taken along the drawn last link.
    """
    board = back_project(camera, observations.pixels, arm_plane_z_mm)
    finite = np.isfinite(board).all(axis=-1)
    if not finite.any():
        raise InputError(
            "recording.json: no marker's pixels can be traced back to the arm's plane; check camera_matrix, "
            "distortion_coefficients and arm_plane_z_mm"
        )
    w = np.where(finite, -board[:, 0] + 1j * board[:, 1], 0.0)  # robot axes, origin at the board's
    drawn, _ = chain.coefficients(np.zeros(len(chain.names)))
    A = observations.directions
    if chain.arm.has_tip_offset:
        n = chain.arm.n_joints
        A = np.concatenate([A[:, : n - 1], A[:, n - 1 : n] + A[:, n:] * (drawn[n] / drawn[n - 1])], axis=1)
        drawn = drawn[:n]
    A = np.concatenate([np.ones((len(A), 1)), A], axis=1)
    target = w - A[:, 1:] @ drawn
    weak = np.diag(np.concatenate([[0.0], np.full(len(drawn), (_SMALL_MM / LENGTH_SPREAD_MM) ** 2)]))
    weight = finite.astype(float)
    change = np.zeros(A.shape[1], dtype=complex)
    for _ in range(_REWEIGHTINGS):
        Aw = A.conj().T * weight
        before, change = change, np.linalg.solve(Aw @ A + weak, Aw @ target)
        if np.abs(change - before).max() < _SMALL_MM:
            break
        weight = finite * _SMALL_MM / np.maximum(np.abs(target - A @ change), _SMALL_MM)
    coefficients = drawn + change[1:]
    return np.concatenate([_link_parameters(chain, coefficients, drawn), [-change[0].real, change[0].imag]])


def _link_parameters(chain: Chain, coefficients: NDArray[np.complex128], drawn: NDArray[np.complex128]) -> Array:
    """Lengths by modulus, joint zeros by the difference of arguments; the last link keeps its drawn angle."""
    turns = np.angle(coefficients / np.where(drawn == 0, 1.0, drawn))
    joints = wrap(np.diff(turns, prepend=0.0))
    if chain.arm.has_tip_offset:
        scale = abs(coefficients[-1]) / max(abs(drawn[-1]), 1e-12)
        l4, l5 = chain.arm.link_lengths_mm[-2:]
        lengths = np.concatenate([np.abs(coefficients[:-1]) - np.abs(drawn[:-1]), [l4 * (scale - 1), l5 * (scale - 1)]])
    else:
        lengths = np.abs(coefficients) - chain.arm.link_lengths_mm
    return np.concatenate([lengths, joints])
