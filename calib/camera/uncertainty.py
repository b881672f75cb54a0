"""How well the views determine the intrinsics: covariance, and what each view contributes.

The normal equations of all parameters are reduced to the shared ones, view by view, by eliminating the view's pose
(Schur complement; Triggs et al. 2000, Bundle adjustment). From the reduced blocks follow, with no further fit,
- the covariance if every corner errs independently and alike (what OpenCV's standard deviations are, too),
- the change of the intrinsics when one view is left out, to first order, and from it the jackknife standard deviation,
  which makes no such assumption: a view that is wrong as a whole shows here, and not in the covariance,
- the standard deviation where errors are alike in each part of the image, which a lens that the model does not follow
  makes them.
What is told to people is the largest of the three.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armtwin.calib.camera.bundle import Bundle, residuals_of, slopes

Array = NDArray[np.float64]

# Below this many views, leaving one out leaves too few for a first-order answer.
MIN_JACKKNIFE_VIEWS = 5
# Cells of the image, each way, within which a lens's error is taken to be alike: a board's square or two.
_CELLS = 6


@dataclass(frozen=True, eq=False)
class Uncertainty:
    """Of the adjusted intrinsics (px for the first four) and the views' poses.

    Attributes:
        names: of the adjusted parameters.
        sigma_px: standard deviation of one coordinate of one corner, from the residuals.
        covariance: (p, p) of the parameters.
        pose_std: (V, 6) standard deviations of rotation (rad, about the camera's axes) and translation (mm).
        without_view: (V, p) change of the intrinsics when the view is left out.
        jackknife_std: (p,) standard deviations from leaving out each view in turn; NaN below `MIN_JACKKNIFE_VIEWS`.
        field_std: (p,) standard deviations where errors are alike in each part of the image.

    """

    names: tuple[str, ...]
    sigma_px: float
    covariance: Array
    pose_std: Array
    without_view: Array
    jackknife_std: Array
    field_std: Array

    @property
    def std(self) -> Array:
        """(p,) standard deviations of the intrinsics, for independent errors alike in all corners."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def total_std(self) -> Array:
        """(p,) standard deviations to believe: the largest of the three."""
        return np.asarray(np.nanmax([self.std, self.jackknife_std, self.field_std], axis=0))


def uncertainty(
    bundle: Bundle, points: Sequence[Array], pixels: Sequence[Array], free: Sequence[str], image_size: tuple[int, int]
) -> Uncertainty:
    """Return the uncertainty of a converged fit of the shared parameters named in `free`.

    `points` are the (N, 3) board points of each view, mm, `pixels` the (N, 2) places where they were seen. Raises
    `numpy.linalg.LinAlgError` where the views leave a parameter undetermined.
    """
    n_views, p = len(points), len(free)
    chosen = [bundle.names.index(name) for name in free]
    residuals = residuals_of(bundle, points, pixels)
    reduced, gradients, gains, pose_inverses, reach = [], [], [], [], []
    for view, residual in enumerate(residuals):
        J_pose, J_shared = slopes(bundle, points[view], view)
        J_in = J_shared[:, chosen]
        C, B = J_pose.T @ J_pose, J_in.T @ J_pose
        gain = np.linalg.solve(C, B.T).T
        own = J_in - J_pose @ gain.T  # what of the slopes no pose can take
        reduced.append(J_in.T @ J_in - gain @ B.T)
        gradients.append(own.T @ residual.ravel())
        gains.append(gain)
        pose_inverses.append(np.linalg.inv(C))
        reach.append((own * residual.ravel()[:, None]).reshape(len(residual), 2, p).sum(axis=1))
    S = np.sum(reduced, axis=0)
    # Columns differ by ten orders of magnitude (px against k3): scale before inverting.
    scale = 1.0 / np.sqrt(np.diag(S))
    S_inverse = np.linalg.inv(S * np.outer(scale, scale)) * np.outer(scale, scale)
    squares, count = sum(float(np.sum(r**2)) for r in residuals), sum(r.size for r in residuals)
    sigma2 = squares / max(count - p - 6 * n_views, 1)
    pose_var = [np.diag(C + g.T @ S_inverse @ g) for C, g in zip(pose_inverses, gains, strict=True)]
    without = _without_each(S, np.array(reduced), np.array(gradients), scale)
    spread = np.full(p, np.nan)
    if n_views >= MIN_JACKKNIFE_VIEWS:
        spread = np.sqrt((n_views - 1) / n_views * np.sum((without - without.mean(axis=0)) ** 2, axis=0))
    return Uncertainty(
        names=tuple(free),
        sigma_px=float(np.sqrt(sigma2)),
        covariance=S_inverse * sigma2,
        pose_std=np.sqrt(np.array(pose_var) * sigma2),
        without_view=without,
        jackknife_std=spread,
        field_std=_field_std(np.vstack(reach) @ S_inverse, np.vstack(pixels), image_size),
    )


def _field_std(pulls: Array, pixels: Array, image_size: tuple[int, int]) -> Array:
    """(p,) standard deviations where errors are alike within each cell of the image, in all views.

    `pulls` (N, p) is by how much each point's residual moves the parameters. A lens that the model does not follow errs
    by place: the pulls of one cell add up instead of cancelling (a covariance clustered by cells; Liang, Zeger 1986).
    """
    column, row = np.clip((pixels + 0.5) / np.array(image_size) * _CELLS, 0, _CELLS - 1).astype(int).T
    cells, cell = np.unique(row * _CELLS + column, return_inverse=True)
    sums = np.zeros((len(cells), pulls.shape[1]))
    np.add.at(sums, cell, pulls)
    if len(cells) < 2:
        return np.full(pulls.shape[1], np.nan)
    return np.sqrt(len(cells) / (len(cells) - 1) * np.sum(sums**2, axis=0))


def _without_each(S: Array, reduced: Array, gradients: Array, scale: Array) -> Array:
    """(V, p) first-order change of the intrinsics when each view is left out."""
    changes = [
        -scale * np.linalg.lstsq((S - block) * np.outer(scale, scale), scale * gradient, rcond=None)[0]
        for block, gradient in zip(reduced, gradients, strict=True)
    ]
    return np.array(changes)
