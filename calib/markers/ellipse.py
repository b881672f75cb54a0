"""Ellipses through edge points: a robust, gradient-weighted conic fit that many discs share in one pass.

The conic of a disc is written about the points' mean c0 and mean distance r0, in y = (x - c0) / r0, as

    (1 + a) y1^2 + 2 b y1 y2 + (1 - a) y2^2 - 2 d y1 - 2 e y2 - f = 0,

which every ellipse satisfies after scaling. It is linear in (a, b, d, e, f); dividing each row by the length of the
conic's gradient makes the residual the distance to the curve to first order (Sampson, CGIP 18, 1982), so a few
reweighted solutions are the geometric fit. A Gaussian prior of standard deviation `shape_prior` on (a, b) holds the
ellipse near a circle: with the whole outline in view the data decide, with a part of it hidden the prior does.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from armtwin.calib.markers.disc import Array, Mask
from armtwin.models.statistics import MAD_TO_STD

# Biweight constant: 95 % efficient on Gaussian residuals (Huber and Ronchetti, Robust Statistics, 2009).
_BIWEIGHT = 4.685
# Median absolute deviation to standard deviation of a Gaussian.
# Residuals below this, px over radius, are rounding: the scale of a perfect fit is not allowed to reach zero.
_LEAST_SCALE = 2e-5
# Keeps a disc without edge points solvable (to a point); 1e-9 of the weight of one edge point.
_RIDGE = 1e-9 * np.eye(5)


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


def fit_ellipses(points: Array, mask: Mask, shape_prior: float, steps: int) -> Ellipses:
    """Fit one ellipse to each row of (K, T, 2) points with a (K, T) boolean mask, by `steps` reweighted solutions.

    `shape_prior` is the standard deviation of the relative difference of the semi-axes.
    """
    start = points.mean(axis=1)
    radius = np.sqrt(((points - start[:, None]) ** 2).sum(axis=-1).mean(axis=-1))
    y = (points - start[:, None]) / radius[:, None, None]
    y1, y2 = y[..., 0], y[..., 1]
    right = -(y1 * y1 + y2 * y2)
    rows = np.stack([y1 * y1 - y2 * y2, 2.0 * y1 * y2, -2.0 * y1, -2.0 * y2, np.full_like(y1, -1.0)], axis=-1)
    prior = np.array([1.0, 1.0, 0.0, 0.0, 0.0]) / shape_prior**2
    # The first guess of the scatter is wide: the first solution leans on the shape, the biweight comes after.
    scale = np.full(len(points), 0.02)
    gradient = 2.0 * np.sqrt(-right)
    weights = mask.astype(float)
    residuals = np.zeros_like(y1)
    for step in range(steps):
        if step:
            weights = mask * _biweight(residuals / scale[:, None])
        weighted = (weights / gradient**2)[..., None] * rows
        normal = weighted.transpose(0, 2, 1) @ rows + np.diag(prior) * (scale**2)[:, None, None] + _RIDGE
        theta = np.linalg.solve(normal, weighted.transpose(0, 2, 1) @ right[..., None])[..., 0]
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


def determinants(shape: Array) -> Array:
    """(K,) absolute determinants of (K, 2, 2) shapes: the products of their semi-axes."""
    return np.abs(shape[:, 0, 0] * shape[:, 1, 1] - shape[:, 0, 1] * shape[:, 1, 0])


def semi_axes(shape: Array) -> Array:
    """(K, 2) semi-axes, the longer first, of the ellipses `shape @ (cos t, sin t)` (K, 2, 2): its singular values."""
    square = (shape**2).sum(axis=(-2, -1))
    twice_area = 2.0 * determinants(shape)
    plus, minus = np.sqrt(square + twice_area), np.sqrt(np.maximum(square - twice_area, 0.0))
    return 0.5 * np.stack([plus + minus, plus - minus], axis=-1)


def _gradient(y1: Array, y2: Array, theta: Array) -> Array:
    """(K, T) length of the conic's gradient at the points; never below a thousandth, as it is at the centre."""
    a, b, d, e = (theta[:, i, None] for i in range(4))
    g1 = (1.0 + a) * y1 + b * y2 - d
    g2 = b * y1 + (1.0 - a) * y2 - e
    return np.maximum(2.0 * np.sqrt(g1 * g1 + g2 * g2), 1e-3)


def _robust_scale(residuals: Array, mask: Mask) -> Array:
    """(K,) standard deviation of the masked residuals by their median absolute value."""
    size = np.where(mask, np.abs(residuals), np.nan)
    size = np.sort(size, axis=1)  # NaN last
    middle = np.maximum(mask.sum(axis=1), 1) // 2
    return np.maximum(MAD_TO_STD * np.nan_to_num(size[np.arange(len(size)), middle]), _LEAST_SCALE)


def _biweight(standardised: Array) -> Array:
    """Tukey's weight of standardised residuals."""
    inside = 1.0 - (standardised / _BIWEIGHT) ** 2
    return np.maximum(inside, 0.0) ** 2


def _centres(theta: Array) -> tuple[Array, Array, Array]:
    """Centre (K, 2), shape (K, 2, 2) and the centre's derivative (K, 2, 5) by (a, b, d, e, f), start circle's units."""
    a, b, d, e, f = theta.T
    det = (1.0 + a) * (1.0 - a) - b * b
    inverse = _symmetric(1.0 - a, -b, 1.0 + a) / det[:, None, None]
    centre = (inverse @ theta[:, 2:4, None])[..., 0]
    size = f + d * centre[:, 0] + e * centre[:, 1]  # (y - c)' Q (y - c) = size on the curve
    # Square root of Q^-1 by Cayley and Hamilton: (Q^-1 + s I) / sqrt(trace Q^-1 + 2 s) with s = det(Q)^-1/2.
    s = 1.0 / np.sqrt(np.maximum(det, 1e-12))
    root = (inverse + s[:, None, None] * np.eye(2)) / np.sqrt(np.maximum(2.0 * s * s + 2.0 * s, 0.0))[:, None, None]
    J = np.zeros((len(theta), 2, 5))
    x, y = centre.T
    # dc = Q^-1 (d(d, e) - dQ c)
    J[:, :, 0] = (inverse @ np.stack([-x, y], axis=-1)[..., None])[..., 0]
    J[:, :, 1] = (inverse @ np.stack([-y, -x], axis=-1)[..., None])[..., 0]
    J[:, :, 2:4] = inverse
    return centre, np.sqrt(np.maximum(size, 0.0))[:, None, None] * root, J


def _symmetric(xx: Array, xy: Array, yy: Array) -> Array:
    """(K, 2, 2) symmetric matrices from their entries (K,)."""
    out = np.empty((len(xx), 2, 2))
    out[:, 0, 0], out[:, 0, 1], out[:, 1, 0], out[:, 1, 1] = xx, xy, xy, yy
    return out
