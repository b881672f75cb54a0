"""Ellipses through edge points: a robust, gradient-weighted conic fit that many discs share in one pass.

The conic of a disc is written about a start circle (centre c0, radius r0), in y = (x - c0) / r0, as

    (1 + a) y1^2 + 2 b y1 y2 + (1 - a) y2^2 - 2 d y1 - 2 e y2 - f = 0,

which every ellipse satisfies after scaling. It is linear in (a, b, d, e, f); dividing each row by the length of the
conic's gradient makes the residual the distance to the curve to first order (Sampson, CGIP 18, 1982), so a few
reweighted solutions are the geometric fit. A Gaussian prior of standard deviation `shape_prior` on (a, b) holds the
ellipse near a circle: with the whole outline in view the data decide, with a part of it hidden the prior does.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

# Biweight constant: 95 % efficient on Gaussian residuals (Huber and Ronchetti, Robust Statistics, 2009).
_BIWEIGHT = 4.685
# Median absolute deviation to standard deviation of a Gaussian.
_MAD_TO_STD = 1.4826
# Residuals below this, px over radius, are rounding: the scale of a perfect fit is not allowed to reach zero.
_LEAST_SCALE = 2e-5


@dataclass(frozen=True, eq=False)
class Ellipses:
    """K ellipses, the points `centre + shape @ (cos t, sin t)`.

    Attributes:
        centre: (K, 2).
        shape: (K, 2, 2) symmetric.
        parameter_normal: (K, 5, 5) normal matrix of (a, b, d, e, f) for unit residual variance, prior included.
        centre_jacobian: (K, 2, 5) derivative of the centre with respect to those parameters.
        residuals: (K, T) signed distances of the points, outside positive, in the points' unit.
        weights: (K, T) robust weights in [0, 1], zero for points that were masked.

    """

    centre: Array
    shape: Array
    parameter_normal: Array
    centre_jacobian: Array
    residuals: Array
    weights: Array

    def covariance(self, edge_std: Array) -> Array:
        """(K, 2, 2) covariance of the centres for (K,) standard deviations of one edge point, points' unit."""
        J = self.centre_jacobian
        return (edge_std**2)[:, None, None] * (J @ np.linalg.solve(self.parameter_normal, J.transpose(0, 2, 1)))


def fit_ellipses(points: Array, mask: Array, start: Array, radius: Array, shape_prior: float, steps: int) -> Ellipses:
    """Fit one ellipse to each row of (K, T, 2) points with a (K, T) boolean mask.

    `start` (K, 2) and `radius` (K,) are the circle that the unknowns are scaled by; `shape_prior` is the standard
    deviation of the relative difference of the semi-axes. `steps` reweighted solutions are made.
    """
    y = (points - start[:, None]) / radius[:, None, None]
    y1, y2 = y[..., 0], y[..., 1]
    right = -(y1 * y1 + y2 * y2)
    rows = np.stack([y1 * y1 - y2 * y2, 2.0 * y1 * y2, -2.0 * y1, -2.0 * y2, np.full_like(y1, -1.0)], axis=-1)
    prior = np.array([1.0, 1.0, 0.0, 0.0, 0.0]) / shape_prior**2
    # The first guess of the scatter is wide, so that the first solution leans on the shape and the biweight comes after.
    scale = np.full(len(points), 0.02)
    gradient = 2.0 * np.sqrt(-right)
    weights = mask.astype(float)
    for step in range(steps):
        if step:
            weights = mask * _biweight(residuals / scale[:, None])
        weighted = (weights / gradient**2)[..., None] * rows
        normal = weighted.transpose(0, 2, 1) @ rows + np.diag(prior) * (scale**2)[:, None, None]
        theta = np.linalg.solve(normal, np.einsum("kti,kt->ki", weighted, right)[..., None])[..., 0]
        gradient = _gradient(y1, y2, theta)
        residuals = ((rows @ theta[..., None])[..., 0] - right) / gradient
        scale = _robust_scale(residuals, mask)
    centre, shape, J = _centres(theta)
    return Ellipses(
        centre=start + radius[:, None] * centre,
        shape=radius[:, None, None] * shape,
        parameter_normal=normal,
        centre_jacobian=J,  # parameters scale as the residuals do, so radii cancel: px of centre per px of edge
        residuals=residuals * radius[:, None],
        weights=weights,
    )


def _gradient(y1: Array, y2: Array, theta: Array) -> Array:
    """(K, T) length of the conic's gradient at the points; never below a thousandth, as it is at the centre."""
    a, b, d, e = (theta[:, i, None] for i in range(4))
    g1 = (1.0 + a) * y1 + b * y2 - d
    g2 = b * y1 + (1.0 - a) * y2 - e
    return np.maximum(2.0 * np.sqrt(g1 * g1 + g2 * g2), 1e-3)


def _robust_scale(residuals: Array, mask: NDArray[np.bool_]) -> Array:
    """(K,) standard deviation of the masked residuals by their median absolute value."""
    size = np.where(mask, np.abs(residuals), np.nan)
    size = np.sort(size, axis=1)  # NaN last
    middle = np.maximum(mask.sum(axis=1), 1) // 2
    return np.maximum(_MAD_TO_STD * np.nan_to_num(size[np.arange(len(size)), middle]), _LEAST_SCALE)


def _biweight(standardised: Array) -> Array:
    """Tukey's weight of standardised residuals."""
    inside = 1.0 - (standardised / _BIWEIGHT) ** 2
    return np.maximum(inside, 0.0) ** 2


def _centres(theta: Array) -> tuple[Array, Array, Array]:
    """Centre (K, 2), shape (K, 2, 2) and the centre's derivative (K, 2, 5) by (a, b, d, e, f), start circle's units."""
    a, b, d, e, f = theta.T
    Q = np.stack([np.stack([1.0 + a, b], -1), np.stack([b, 1.0 - a], -1)], -2)
    inverse = np.linalg.inv(Q)
    right = np.stack([d, e], -1)
    centre = (inverse @ right[..., None])[..., 0]
    size = f + np.sum(right * centre, axis=-1)  # (y - c)' Q (y - c) = size on the curve
    # Inverse square root of a 2 x 2 symmetric matrix by Cayley-Hamilton: sqrt(Q) = (Q + s I) / t.
    s = np.sqrt(np.maximum(np.linalg.det(Q), 1e-12))
    t = np.sqrt(np.trace(Q, axis1=1, axis2=2) + 2.0 * s)
    root_inverse = np.linalg.inv((Q + s[:, None, None] * np.eye(2)) / t[:, None, None])
    shape = np.sqrt(np.maximum(size, 0.0))[:, None, None] * root_inverse
    J = np.zeros((len(theta), 2, 5))
    x, y = centre.T
    # dc = Q^-1 (d(d, e) - dQ c)
    J[:, :, 0] = np.einsum("kij,kj->ki", inverse, np.stack([-x, y], -1))
    J[:, :, 1] = np.einsum("kij,kj->ki", inverse, np.stack([-y, -x], -1))
    J[:, :, 2:4] = inverse
    return centre, shape, J
