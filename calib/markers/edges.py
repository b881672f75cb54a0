"""Sub-pixel edge points along the normals of first ellipses, all discs of a picture at once.

Along a normal at the distance n from the edge, outside positive, a blurred disc reads

    I(n) = ground + (face - ground) * Phi(-n / s),

Phi the Gaussian distribution function and s the blur with the pixel's own width in it. The displacement of each edge
point is its least-squares estimate, one matched-filter step per pass: sum(g r) / sum(g^2) with g = dI/dn and r the
remainder. Passes move the ellipse, so that the step is short in the last one. The face is allowed a linear shading
(vignetting, uneven light) and the ground may differ from normal to normal, since an error of these levels moves
opposite edges the same way. Each is shrunk towards a constant as far as its scatter is what noise alone would give
(James and Stein, 1961), as estimating what is not there costs accuracy.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from calib.markers.disc import Array, Image

Mask = NDArray[np.bool_]

# Samples on a normal; with the reach below their spacing stays about a pixel up to a blur of 3 px.
SAMPLES = 27
# Reach of a normal to both sides: 4 blurs and a little more, so that both ends read level.
_REACH_BLURS, _REACH_PX, _REACH_MOST = 4.0, 1.5, 14.0
# Reach of the first pass, which does not know the blur and has to forgive a first ellipse a pixel off.
_FIRST_REACH, _FIRST_REACH_RADII = 10.0, 0.6
# Distance from the edge, in blurs, beyond which the profile is level to 1.2 % of its height.
_LEVEL_FROM = 2.25
# A pixel's own width is a blur of 0.29 px and interpolation adds about as much.
BLUR_LEAST, BLUR_MOST = 0.45, 5.0
# Shares of the median contrast between which a normal crosses an edge of the disc, and not of something before it.
_LEAST_CONTRAST, _MOST_CONTRAST = 0.65, 1.5
# Neighbouring normals share pixels: their noise adds up as if there were fewer of them by about this factor.
_SHARED = 1.6


@dataclass(frozen=True, eq=False)
class EdgePoints:
    """Edge points of K discs on T normals each.

    Attributes:
        points: (K, T, 2) raw pixels.
        mask: (K, T) whether there is an edge of the disc.
        contrast: (K,) grey levels.
        blur: (K,) px.

    """

    points: Array
    mask: Mask
    contrast: Array
    blur: Array


@dataclass(frozen=True, eq=False)
class _Normals:
    """Grey levels (K, T, S) read on normals of `directions` (K, T, 2) at distances `n` (K, S) from `feet` (K, T, 2)."""

    feet: Array
    directions: Array
    n: Array
    grey: Array
    seen: Mask


def sample(image: Image, x: Array, y: Array) -> Array:
    """Bilinear grey levels of a (H, W) picture at raw pixels x, y of one shape; NaN outside the picture."""
    height, width = image.shape
    inside = (x >= 0.0) & (y >= 0.0) & (x <= width - 1.0) & (y <= height - 1.0)
    column = np.clip(x, 0.0, width - 1.001).astype(np.intp)
    row = np.clip(y, 0.0, height - 1.001).astype(np.intp)
    fx, fy = x - column, y - row
    upper = image[row, column] * (1.0 - fx) + image[row, column + 1] * fx
    lower = image[row + 1, column] * (1.0 - fx) + image[row + 1, column + 1] * fx
    return np.where(inside, upper + fy * (lower - upper), np.nan)


def n_normals(radius: float) -> int:
    """Return the number of normals for a disc of this radius, px: one every 1.25 px, so that no pixel is left out."""
    return int(np.clip(np.ceil(2.0 * np.pi * radius / 1.25 / 8.0), 4, 40)) * 8


def first_edges(image: Image, centre: Array, shape: Array, normals: int) -> EdgePoints:
    """Coarse edge points of K ellipses `centre` (K, 2), `shape` (K, 2, 2), from moments of the profile, any blur.

    With p the profile scaled to 1 inside and 0 outside and H the unblurred step, the zeroth moment of p - H is the
    edge's displacement d and its first moment is (blur^2 + d^2) / 2.
    """
    reach = np.minimum(_FIRST_REACH, _FIRST_REACH_RADII * _minor_axes(shape))
    lines = _read(image, centre, shape, reach, normals)
    far = 0.7 * reach[:, None]
    face, ground = _mean_where(lines.grey, lines.n < -far), _mean_where(lines.grey, lines.n > far)
    contrast, mask = _disc_edges(face, ground, lines.seen)
    spacing = lines.n[:, 1] - lines.n[:, 0]
    n = lines.n[:, None]
    excess = (lines.grey - ground[..., None]) / contrast[:, None, None] - 0.5 * (1.0 - np.sign(n))
    excess[..., [0, -1]] *= 0.5  # trapezoids
    shift = excess.sum(axis=-1) * spacing[:, None]
    second = 2.0 * (n * excess).sum(axis=-1) * spacing[:, None] - shift**2
    blur = np.sqrt(np.clip(_masked_median(second, mask), BLUR_LEAST**2, BLUR_MOST**2))
    return _points(lines, shift, mask & (np.abs(shift) < far), contrast, blur)


def find_edges(image: Image, centre: Array, shape: Array, blur: Array, normals: int) -> EdgePoints:
    """Edge points on `normals` normals of K ellipses that are within half a blur or so of the edge.

    `centre` (K, 2), `shape` (K, 2, 2) in raw pixels of the (H, W) picture; `blur` (K,) px is improved by one step.
    """
    reach = np.minimum(np.minimum(_REACH_BLURS * blur + _REACH_PX, _REACH_MOST), 0.85 * _minor_axes(shape))
    lines = _read(image, centre, shape, reach, normals)
    far = np.minimum(_LEVEL_FROM * blur, 0.7 * reach)[:, None]
    face, ground = _mean_where(lines.grey, lines.n < -far), _mean_where(lines.grey, lines.n > far)
    contrast, mask = _disc_edges(face, ground, lines.seen)
    face, ground = _linear_face(face, mask), _local_ground(ground, mask)
    height = face - ground

    scaled = lines.n / blur[:, None]
    inside = ndtr(-scaled)
    slope = np.exp(-0.5 * scaled**2) / (np.sqrt(2.0 * np.pi) * blur[:, None])
    remainder = (lines.grey - ground[..., None]) / height[..., None] - inside[:, None]
    shift = (remainder @ slope[..., None])[..., 0] / (slope**2).sum(axis=-1, keepdims=True)
    # d profile / d blur = slope n / blur: odd about the edge where the shift is even, so each is found on its own.
    widening = slope * scaled
    wider = (remainder @ widening[..., None])[..., 0] / (widening**2).sum(axis=-1, keepdims=True)
    new_blur = np.clip(blur + np.clip(_masked_median(wider, mask), -0.3 * blur, 0.3 * blur), BLUR_LEAST, BLUR_MOST)
    return _points(lines, shift, mask & (np.abs(shift) < 1.5 * blur[:, None]), contrast, new_blur)


def _minor_axes(shape: Array) -> Array:
    minor: Array = np.linalg.svd(shape, compute_uv=False)[:, -1]
    return minor


def _read(image: Image, centre: Array, shape: Array, reach: Array, normals: int) -> _Normals:
    angle = 2.0 * np.pi * np.arange(normals) / normals
    circle = np.stack([np.cos(angle), np.sin(angle)])
    feet = centre[:, None] + (shape @ circle).transpose(0, 2, 1)
    directions = (np.linalg.inv(shape).transpose(0, 2, 1) @ circle).transpose(0, 2, 1)
    directions /= np.linalg.norm(directions, axis=-1, keepdims=True)
    n = reach[:, None] * np.linspace(-1.0, 1.0, SAMPLES)
    x, y = (feet[:, :, None, i] + n[:, None] * directions[:, :, None, i] for i in range(2))
    grey = sample(image, x, y)
    seen = ~np.isnan(grey[..., [0, -1]]).any(axis=-1)  # a straight normal with both ends in the picture is all in it
    return _Normals(feet, directions, n, np.where(seen[..., None], grey, 0.0), seen)


def _points(lines: _Normals, shift: Array, mask: Mask, contrast: Array, blur: Array) -> EdgePoints:
    shift = np.where(mask, shift, 0.0)
    return EdgePoints(lines.feet + shift[..., None] * lines.directions, mask, contrast, blur)


def _mean_where(grey: Array, where: Mask) -> Array:
    """(K, T) mean of the samples (K, T, S) at the places (K, S)."""
    share = where / np.maximum(where.sum(axis=-1, keepdims=True), 1)
    mean: Array = (grey @ share[..., None])[..., 0]
    return mean


def _masked_median(values: Array, mask: Mask) -> Array:
    """(K,) median of (K, T) values where the mask holds; 0 where it never does."""
    ordered = np.sort(np.where(mask, values, np.inf), axis=-1)
    middle = ordered[np.arange(len(values)), mask.sum(axis=-1) // 2]
    return np.where(np.isfinite(middle), middle, 0.0)


def _disc_edges(face: Array, ground: Array, seen: Mask) -> tuple[Array, Mask]:
    """(K,) contrast, and (K, T) which normals go from the disc's face to something clearly darker."""
    usual_face = _masked_median(face, seen)
    contrast = np.maximum(usual_face - _masked_median(ground, seen), 1.0)
    height = (face - ground) / contrast[:, None]
    from_face = np.abs(face - usual_face[:, None]) < (1.0 - _LEAST_CONTRAST) * contrast[:, None]
    return contrast, seen & from_face & (height > _LEAST_CONTRAST) & (height < _MOST_CONTRAST)


def _linear_face(face: Array, mask: Mask) -> Array:
    """(K, T) the face's level at each normal: a constant and a shrunk linear shading."""
    K, T = face.shape
    angle = 2.0 * np.pi * np.arange(T) / T
    rows = np.stack([np.ones(T), np.cos(angle), np.sin(angle)], axis=-1)
    normal = np.einsum("kt,ti,tj->kij", mask.astype(float), rows, rows) + 1e-9 * np.eye(3)
    levels = np.linalg.solve(normal, ((mask * face) @ rows)[..., None])[..., 0]
    fitted = levels @ rows.T
    n_seen = np.maximum(mask.sum(axis=-1), 4)
    noise = _SHARED * np.sum(mask * (face - fitted) ** 2, axis=-1) / (n_seen - 3)
    error = noise * np.trace(np.linalg.inv(normal)[:, 1:, 1:], axis1=1, axis2=2) / 2.0
    levels[:, 1:] *= _kept_share(np.mean(levels[:, 1:] ** 2, axis=-1), error)[:, None]
    shaded: Array = levels @ rows.T
    return shaded


def _local_ground(ground: Array, mask: Mask) -> Array:
    """(K, T) the ground's level at each normal: its mean, and shrunk deviations smoothed over a sixteenth turn."""
    K, T = ground.shape
    half = max(1, T // 32)
    lag = np.abs(np.arange(T)[:, None] - np.arange(T))
    near = (np.minimum(lag, T - lag) <= half).astype(float)
    n_seen = np.maximum(mask.sum(axis=-1), 1)
    mean = np.sum(mask * ground, axis=-1) / n_seen
    deviation = np.where(mask, ground - mean[:, None], 0.0)
    count = np.maximum(mask @ near, 1.0)
    smooth = (deviation @ near) / count
    noise = np.sum(mask * (deviation - smooth) ** 2, axis=-1) / n_seen * _SHARED / (2 * half + 1)
    kept = _kept_share(np.sum(mask * smooth**2, axis=-1) / n_seen, noise)
    return mean[:, None] + kept[:, None] * smooth


def _kept_share(power: Array, error: Array) -> Array:
    """(K,) share of estimated deviations that is kept, given their mean square and that of their error (K,)."""
    true_power = max(float(np.mean(power - error)), 0.0)
    return true_power / np.maximum(true_power + error, 1e-12)
