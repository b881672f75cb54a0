"""Sub-pixel edge points along the normals of first ellipses, all discs of a picture at once.

Along a normal at the distance n from the edge, outside positive, a blurred disc reads

    I(n) = ground + (face(n) - ground) * Phi(-n / s),

Phi the Gaussian distribution function and s the blur with the pixel's own width in it. The displacement of each edge
point is its least-squares estimate, one matched-filter step per pass: sum(g r) / sum(g^2) with g = dI/dn and r the
remainder. Passes move the ellipse, so that the step is short in the last one.

An error of the levels moves opposite edges the same way, and so the centre: the levels of face and ground are measured
on each normal (see `levels`), vignetting and uneven light included.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.lib.stride_tricks import as_strided
from scipy.special import ndtr

from armtwin.calib.markers.disc import Array, Image, Mask
from armtwin.calib.markers.ellipse import determinants, semi_axes
from armtwin.calib.markers.levels import Profile, disc_edges, find_levels, masked_median, mean_where

# Distance of samples on a normal, in blurs and at most in px: closer ones add time, not information.
_SPACING_BLURS, _SPACING_MOST = 0.7, 0.8
# Distance of normals on the outline, px: interpolation reads two pixels' width, so none is left out.
_NORMALS_APART = 1.5
# Reach of a normal to both sides: 4 blurs and a little more, so that both ends read level.
_REACH_BLURS, _REACH_PX, _REACH_MOST = 4.0, 1.5, 14.0
# The ground is taken to be even for 0.3 of a radius (printed stickers have half, gauges a third); normals end where the
# blur of what lies beyond is down to 7 %, but not before most of the edge is over.
_GROUND_RADII, _CLEAR_BLURS, _LEAST_OUT_BLURS = 0.3, 1.5, 1.5
# Reach of the first pass, which does not know the blur and has to forgive a first ellipse a pixel off.
_FIRST_REACH, _FIRST_REACH_RADII, _FIRST_REACH_LEAST = 8.0, 0.6, 3.5
# A pixel's own width is a blur of 0.29 px and interpolation adds about as much.
BLUR_LEAST, BLUR_MOST = 0.45, 5.0
# A normal is unlike the others where its remainder is over five times their usual one and over 3 % of the contrast.
_UNLIKE, _UNLIKE_CONTRAST = 5.0, 0.03
# How far from what hides the outline normals are left out.
_GAP_BLURS, _GAP_PX = 2.0, 3.0
# Bilinear interpolation at uniformly spread places keeps (2/3)^2 of the variance of white pixel noise.
_INTERPOLATED_NOISE = 4.0 / 9.0


@dataclass(frozen=True, eq=False)
class EdgePoints:
    """Edge points of K discs on T normals each.

    Attributes:
        points: (K, T, 2) raw pixels.
        mask: (K, T) whether there is an edge of the disc.
        contrast: (K,) grey levels.
        blur: (K,) px.
        noise: (K,) standard deviation of one pixel about the profile, grey levels.
        edge_std: (K,) px of one edge point from that noise, as if the noise of the T points were independent.
        level_std: (K,) px of a coordinate of the centre from the noise of the levels.

    """

    points: Array
    mask: Mask
    contrast: Array
    blur: Array
    noise: Array
    edge_std: Array
    level_std: Array


@dataclass(frozen=True, eq=False)
class _Normals:
    """Grey levels (K, T, S) read on normals of `directions` (K, T, 2) at distances `n` (K, S) from `feet` (K, T, 2)."""

    feet: Array
    directions: Array
    n: Array
    grey: Array
    seen: Mask
    radius: Array


def sample(image: Image, x: Array, y: Array) -> Array:
    """Bilinear grey levels of a (H, W) picture at raw pixels x, y of one shape; NaN outside the picture.

    The picture is contiguous or a channel of one that is: its strides are not negative.
    """
    height, width = image.shape
    column = np.clip(x, 0.0, width - 1.001).astype(np.intp)
    row = np.clip(y, 0.0, height - 1.001).astype(np.intp)
    fx, fy = x - column, y - row
    inside = (np.abs(fx - 0.5) <= 0.501) & (np.abs(fy - 0.5) <= 0.501)
    # The picture may be one channel of three: its bytes are read where they lie, since a copy takes longer than this.
    pixels = as_strided(image, ((height - 1) * image.strides[0] + (width - 1) * image.strides[1] + 1,), (1,))
    at = row * image.strides[0] + column * image.strides[1]
    right = image.strides[1]
    upper = pixels.take(at).astype(float)
    upper += fx * (pixels.take(at + right) - upper)
    at += image.strides[0]
    lower = pixels.take(at).astype(float)
    lower += fx * (pixels.take(at + right) - lower)
    return np.where(inside, upper + fy * (lower - upper), np.nan)


def n_normals(radius: float) -> int:
    """Return the number of normals for a disc of this radius, px: close enough to use every pixel."""
    return int(np.clip(np.ceil(2.0 * np.pi * radius / _NORMALS_APART / 8.0), 4, 40)) * 8


def first_edges(image: Image, centre: Array, shape: Array, normals: int) -> EdgePoints:
    """Coarse edge points of K ellipses `centre` (K, 2), `shape` (K, 2, 2), from moments of the profile, any blur.

    With p the profile scaled to 1 inside and 0 outside and H the unblurred step, the zeroth moment of p - H is the
    edge's displacement d and its first moment is (blur^2 + d^2) / 2.
    """
    minor = semi_axes(shape)[:, 1]
    inner = np.minimum(_FIRST_REACH, _FIRST_REACH_RADII * minor)
    outer = np.minimum(inner, np.maximum(_GROUND_RADII * minor, _FIRST_REACH_LEAST))
    lines = _read(image, centre, shape, inner, outer, _SPACING_MOST, normals)
    face = mean_where(lines.grey, lines.n < -0.7 * inner[:, None])
    ground = mean_where(lines.grey, lines.n > 0.7 * outer[:, None])
    contrast, mask = disc_edges(face, ground, lines.seen)
    spacing = (lines.n[:, 1] - lines.n[:, 0])[:, None]
    n = lines.n[:, None]
    excess = (lines.grey - ground[..., None]) / contrast[:, None, None] - 0.5 * (1.0 - np.sign(n))
    excess[..., [0, -1]] *= 0.5  # trapezoids
    shift = excess.sum(axis=-1) * spacing
    second = 2.0 * (n * excess).sum(axis=-1) * spacing - shift**2
    mask &= np.abs(shift) < 0.7 * outer[:, None]
    blur = np.sqrt(np.clip(masked_median(second, mask), BLUR_LEAST**2, BLUR_MOST**2))
    none = np.zeros(len(blur))
    return EdgePoints(_moved(lines, shift, mask), mask, contrast, blur, noise=none, edge_std=none, level_std=none)


def find_edges(image: Image, centre: Array, shape: Array, normals: int, blur: Array, noise: Array) -> EdgePoints:
    """Edge points on the normals of K ellipses that are within half a blur or so of the edge.

    `centre` (K, 2), `shape` (K, 2, 2) in raw pixels of the (H, W) picture; `blur` (K,) px and `noise` (K,) grey levels
    (0 if unknown) are the last pass's.
    """
    inner, outer = _reach(semi_axes(shape)[:, 1], blur)
    spacing = min(_SPACING_BLURS * float(blur.min()), _SPACING_MOST)
    lines = _read(image, centre, shape, inner, outer, spacing, normals)
    scaled = lines.n / blur[:, None]
    slope = np.exp(-0.5 * scaled**2) / (np.sqrt(2.0 * np.pi) * blur[:, None])
    profile = Profile(lines.n, ndtr(-scaled), slope, lines.radius, blur)
    levels = find_levels(lines.grey, profile, lines.seen, noise)
    mask = levels.mask

    remainder = levels.remainder / np.maximum(levels.height, 1.0)[..., None]
    along_slope, slope_power = (remainder @ slope[..., None])[..., 0], (slope**2).sum(axis=-1, keepdims=True)
    shift = along_slope / slope_power
    # d profile / d blur = slope n / blur is nearly odd about the edge where the slope is even: each is found alone.
    widening = slope * scaled
    along_widening = (remainder @ widening[..., None])[..., 0]
    widening_power = (widening**2).sum(axis=-1, keepdims=True)
    growth = np.clip(masked_median(along_widening / widening_power, mask), -0.3 * blur, 0.3 * blur)

    # What is left when the better edge is taken out is noise: two of its S degrees of freedom are spent.
    left = (remainder**2).sum(axis=-1) - along_slope**2 / slope_power - along_widening**2 / widening_power
    usual = masked_median(left, mask)
    variance = usual / (remainder.shape[-1] - 2)
    relative_noise = np.sqrt(np.maximum(variance, 0.0) / _INTERPOLATED_NOISE)
    arc = 2.0 * np.pi * lines.radius / normals

    unlike = np.maximum(_UNLIKE * usual, remainder.shape[-1] * _UNLIKE_CONTRAST**2)[:, None]
    mask &= (np.abs(shift) < 1.5 * blur[:, None]) & (left < unlike)
    mask = _away_from_gaps(mask, (_GAP_BLURS * blur + _GAP_PX) / arc)
    # As if each point had the pixels of its arc to itself: noise^2 / (arc * integral of slope^2 = 1 / (2 sqrt(pi) s)).
    edge_std = relative_noise * np.sqrt(2.0 * np.sqrt(np.pi) * blur / arc)
    return EdgePoints(
        points=_moved(lines, shift, mask),
        mask=mask,
        contrast=levels.contrast,
        blur=np.clip(blur + growth, BLUR_LEAST, BLUR_MOST),
        noise=relative_noise * levels.contrast,
        edge_std=edge_std,
        level_std=levels.std,
    )


def _away_from_gaps(mask: Mask, reach: Array) -> Mask:
    """(K, T) the mask without the normals within `reach` (K,) places of one that is not an edge of the disc.

    What covers a part of the outline also spoils its neighbours, less and less visibly.
    """
    if mask.all():
        return mask
    T = mask.shape[1]
    gaps = ~mask
    spoilt = gaps.copy()
    for lag in range(1, min(int(reach.max()), T // 4) + 1):
        near = gaps & (reach >= lag)[:, None]
        spoilt |= np.roll(near, lag, axis=1) | np.roll(near, -lag, axis=1)
    return ~spoilt


def _reach(minor: Array, blur: Array) -> tuple[Array, Array]:
    """Lengths of the normals inside and outside the edge (K,), px."""
    level = np.minimum(_REACH_BLURS * blur + _REACH_PX, _REACH_MOST)
    ground = np.maximum(_GROUND_RADII * minor - _CLEAR_BLURS * blur, _LEAST_OUT_BLURS * blur)
    return np.minimum(level, 0.85 * minor), np.minimum(level, ground)


def _read(
    image: Image, centre: Array, shape: Array, inner: Array, outer: Array, spacing: float, normals: int
) -> _Normals:
    circle = _circle(normals)
    feet = centre[:, None] + (shape @ circle).transpose(0, 2, 1)
    directions = (np.linalg.inv(shape).transpose(0, 2, 1) @ circle).transpose(0, 2, 1)
    directions /= np.sqrt((directions**2).sum(axis=-1, keepdims=True))
    steps = int(np.ceil((inner + outer).max() / spacing))
    n = (inner + outer)[:, None] * np.linspace(0.0, 1.0, steps + 1) - inner[:, None]
    x, y = (feet[:, :, None, i] + n[:, None] * directions[:, :, None, i] for i in range(2))
    grey = sample(image, x, y)
    seen: Mask = np.isfinite(grey[..., 0] + grey[..., -1])  # with both ends in the picture a normal is all in it
    if not seen.all():
        grey = np.where(seen[..., None], grey, 0.0)
    return _Normals(feet, directions, n, grey, seen, np.sqrt(determinants(shape)))


@lru_cache(maxsize=64)
def _circle(normals: int) -> Array:
    """(2, T) unit vectors."""
    angle = 2.0 * np.pi * np.arange(normals) / normals
    return np.stack([np.cos(angle), np.sin(angle)])


def _moved(lines: _Normals, shift: Array, mask: Mask) -> Array:
    return lines.feet + np.where(mask, shift, 0.0)[..., None] * lines.directions
