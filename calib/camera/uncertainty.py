"""How well the views determine the intrinsics: covariance, and what each view contributes.

The normal equations of all parameters are reduced to the nine intrinsics, view by view, by eliminating the view's pose
(Schur complement; Triggs et al. 2000, Bundle adjustment). From the reduced blocks follow, with no further fit,
- the covariance if every corner errs independently and alike (what OpenCV's standard deviations are, too),
- the change of the intrinsics when one view is left out, to first order, and from it the jackknife standard deviation,
  which makes no such assumption: a view that is wrong as a whole shows here, and not in the covariance.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

INTRINSICS = ("fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3")
# Below this many views, leaving one out leaves too few for a first-order answer.
MIN_JACKKNIFE_VIEWS = 5


@dataclass(frozen=True, eq=False)
class Uncertainty:
    """Of the intrinsics in the order of `INTRINSICS` (px for the first four) and the views' poses.

    Attributes:
        sigma_px: standard deviation of one coordinate of one corner, from the residuals.
        covariance: (9, 9) of the intrinsics.
        pose_std: (V, 6) standard deviations of rotation (rad, about the camera's axes) and translation (mm).
        without_view: (V, 9) change of the intrinsics when the view is left out.
        jackknife_std: (9,) standard deviations from leaving out each view in turn; NaN below `MIN_JACKKNIFE_VIEWS`.

    """

    sigma_px: float
    covariance: Array
    pose_std: Array
    without_view: Array
    jackknife_std: Array

    @property
    def std(self) -> Array:
        """(9,) standard deviations of the intrinsics, for independent errors alike in all corners."""
        return np.sqrt(np.diag(self.covariance))


def uncertainty(points_mm: Array, residuals_px: Array, poses: Array, K: Array, D: Array) -> Uncertainty:
    """Return the uncertainty of a converged fit.

    `points_mm` (N, 3) board corners, `residuals_px` (V, N, 2) measured less predicted, `poses` (V, 6) rotation vectors
    and translations. Raises `numpy.linalg.LinAlgError` where the views leave a parameter undetermined.
    """
    n_views = len(residuals_px)
    reduced, gradients, gains, pose_inverses = [], [], [], []
    for pose, residual in zip(poses, residuals_px, strict=True):
        J = _jacobian(points_mm, pose, K, D)
        J_pose, J_in = J[:, :6], J[:, 6:]
        C, B = J_pose.T @ J_pose, J_in.T @ J_pose
        gain = np.linalg.solve(C, B.T).T
        reduced.append(J_in.T @ J_in - gain @ B.T)
        gradients.append((J_in - J_pose @ gain.T).T @ residual.ravel())
        gains.append(gain)
        pose_inverses.append(np.linalg.inv(C))
    S = np.sum(reduced, axis=0)
    # Columns differ by ten orders of magnitude (px against k3): scale before inverting.
    scale = 1.0 / np.sqrt(np.diag(S))
    S_inverse = np.linalg.inv(S * np.outer(scale, scale)) * np.outer(scale, scale)
    freedom = residuals_px.size - len(INTRINSICS) - 6 * n_views
    sigma2 = float(np.sum(residuals_px**2)) / freedom
    pose_var = [np.diag(C + g.T @ S_inverse @ g) for C, g in zip(pose_inverses, gains, strict=True)]
    without = _without_each(S, np.array(reduced), np.array(gradients), scale)
    spread = np.full(len(INTRINSICS), np.nan)
    if n_views >= MIN_JACKKNIFE_VIEWS:
        spread = np.sqrt((n_views - 1) / n_views * np.sum((without - without.mean(axis=0)) ** 2, axis=0))
    return Uncertainty(
        sigma_px=float(np.sqrt(sigma2)),
        covariance=S_inverse * sigma2,
        pose_std=np.sqrt(np.array(pose_var) * sigma2),
        without_view=without,
        jackknife_std=spread,
    )


def _without_each(S: Array, reduced: Array, gradients: Array, scale: Array) -> Array:
    """(V, 9) first-order change of the intrinsics when each view is left out."""
    changes = [
        -scale * np.linalg.lstsq((S - block) * np.outer(scale, scale), scale * gradient, rcond=None)[0]
        for block, gradient in zip(reduced, gradients, strict=True)
    ]
    return np.array(changes)


def _jacobian(points_mm: Array, pose: Array, K: Array, D: Array) -> Array:
    """(2 N, 15) derivative of the pixels with respect to rotation (about camera axes), translation and intrinsics."""
    _, derivatives = cv2.projectPoints(points_mm, pose[:3], pose[3:], K, D)
    J: Array = np.array(derivatives[:, :15], dtype=np.float64)
    # A small turn w about the camera's axes moves R X by w × R X; OpenCV differentiates by the rotation vector instead,
    # whose elements mean no angle that a person could read.
    R, d_R = cv2.Rodrigues(pose[:3])
    generators = np.zeros((3, 3, 3))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        generators[i, j, k], generators[i, k, j] = -1.0, 1.0
    turns = np.stack([(g @ R).ravel() for g in generators])  # (3, 9): d R / d w
    to_vector = np.linalg.lstsq(d_R.T, turns.T, rcond=None)[0]  # (3, 3): d rvec / d w
    J[:, :3] = J[:, :3] @ to_vector
    return J
