"""Grey levels of a disc's face and of the ground around it, on every normal, and how well they are known.

The face may be shaded linearly (vignetting, uneven light) and the ground may differ from place to place. Estimating
what is not there costs accuracy, so both departures from a constant are shrunk as far as their size is what noise alone
would give, judged over all discs of the picture together (James and Stein, 1961).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from armtwin.calib.markers.disc import Array, Mask

# Distance from the edge, in blurs, beyond which the profile is level to 1.2 % of its height.
_LEVEL_FROM = 2.25
# Length of level ground on a normal, px, from which it is read there.
_LEVEL_PX = 2.0
# Shares of the usual contrast between which a normal crosses an edge of the disc, and not of something before it.
_LEAST_CONTRAST, _MOST_CONTRAST = 0.65, 1.5


@dataclass(frozen=True, eq=False)
class Profile:
    """The unit edge of K discs at the S places of their normals.

    Attributes:
        n: (K, S) distance from the edge, outside positive, px.
        inside: (K, S) share of the face, Phi(-n / blur).
        slope: (K, S) its derivative by a displacement of the edge, 1/px.
        radius, blur: (K,) px.

    """

    n: Array
    inside: Array
    slope: Array
    radius: Array
    blur: Array


@dataclass(frozen=True, eq=False)
class Levels:
    """Levels of K discs on T normals, in grey levels.

    Attributes:
        remainder: (K, T, S) what the profile with these levels leaves of the grey levels.
        height: (K, T) face less ground at the edge.
        contrast: (K,) their usual difference.
        mask: (K, T) which normals go from the face to something clearly darker.
        std: (K,) px of a coordinate of the centre from the noise of the levels.

    """

    remainder: Array
    height: Array
    contrast: Array
    mask: Mask
    std: Array


def find_levels(grey: Array, profile: Profile, seen: Mask, noise: Array) -> Levels:
    """Measure the levels from grey levels (K, T, S) on normals, of which `seen` (K, T) are in the picture.

    `noise` (K,) is one pixel's standard deviation, 0 where it is not known yet. The face is read where the profile is
    level, and so is the ground where enough of it is free of what lies beyond; else it is solved for along with the
    displacement.
    """
    n, inside, slope, radius = profile.n, profile.inside, profile.slope, profile.radius
    outside = 1.0 - inside
    spacing = n[:, 1] - n[:, 0]
    on_face = n < -np.minimum(_LEVEL_FROM * profile.blur, -0.6 * n[:, 0])[:, None]
    where_face = radius + mean_where(n[:, None], on_face)[:, 0]
    face_level = mean_where(grey, on_face)
    # Twice the variance of a mean over a ring's pixels is that of a harmonic's amplitude.
    pixel_area = 2.0 * noise**2 / (2.0 * np.pi * spacing)
    face_error = pixel_area / (where_face * on_face.sum(axis=-1))

    ss, so, oo = (slope**2).sum(axis=-1), (slope * outside).sum(axis=-1), (outside**2).sum(axis=-1)
    free = ss * oo - so**2
    solved = (ss[:, None] * outside - so[:, None] * slope) / free[:, None]
    on_ground = n > _LEVEL_FROM * profile.blur[:, None]
    level_px = on_ground.sum(axis=-1) * spacing
    is_level = (level_px >= _LEVEL_PX)[:, None]
    weights = np.where(is_level, on_ground * (spacing / np.maximum(level_px, spacing))[:, None], solved)
    ground_level = ((grey - face_level[..., None] * inside[:, None]) @ weights[..., None])[..., 0]
    # Pixels that these weights average over: the inverse of their sum of squares; for `solved` that is free / ss.
    ground_error = pixel_area / radius * (weights**2).sum(axis=-1)
    contrast, mask = disc_edges(face_level, ground_level, seen)

    face, tilt, kept_face = _linear(face_level, mask, face_error)
    gain = radius / where_face
    shading = tilt * gain[:, None]
    lit = inside * (1.0 + n / radius[:, None])
    ground, kept_ground = _local(ground_level, mask, ground_error)
    remainder = grey - face[..., None] * inside[:, None] - shading[..., None] * lit[:, None]
    remainder -= ground[..., None] * outside[:, None]
    # Displacement that an error of each level would feign.
    by_face, by_ground = (slope * inside).sum(axis=-1) / ss, so / ss
    variance = kept_face * face_error * (gain * by_face) ** 2 + kept_ground * ground_error * by_ground**2
    return Levels(remainder, face + shading - ground, contrast, mask, np.sqrt(variance) / contrast)


def disc_edges(face: Array, ground: Array, seen: Mask) -> tuple[Array, Mask]:
    """(K,) contrast, and (K, T) which normals go from the disc's face to something clearly darker."""
    usual_face = masked_median(face, seen)
    contrast = np.maximum(usual_face - masked_median(ground, seen), 1.0)
    height = (face - ground) / contrast[:, None]
    from_face = np.abs(face - usual_face[:, None]) < (1.0 - _LEAST_CONTRAST) * contrast[:, None]
    return contrast, seen & from_face & (height > _LEAST_CONTRAST) & (height < _MOST_CONTRAST)


def mean_where(grey: Array, where: Mask) -> Array:
    """(K, T) mean of the samples (K, T, S) at the places (K, S)."""
    share = where / np.maximum(where.sum(axis=-1, keepdims=True), 1)
    mean: Array = (grey @ share[..., None])[..., 0]
    return mean


def masked_median(values: Array, mask: Mask) -> Array:
    """(K,) median of (K, T) values where the mask holds; 0 where it never does."""
    ordered = np.sort(np.where(mask, values, np.inf), axis=-1)
    middle = ordered[np.arange(len(values)), mask.sum(axis=-1) // 2]
    middle[np.isinf(middle)] = 0.0
    return middle


def _linear(values: Array, mask: Mask, error: Array) -> tuple[Array, Array, Array]:
    """Constant (K, 1), shrunk first harmonic (K, T) and its kept share (K,) of (K, T) values on a circle.

    `error` (K,) is the variance of a harmonic's amplitude.
    """
    rows = _harmonics(values.shape[1])
    weighted = mask[..., None] * rows
    normal = weighted.transpose(0, 2, 1) @ rows + 1e-9 * np.eye(3)
    levels: Array = np.linalg.solve(normal, (weighted.transpose(0, 2, 1) @ values[..., None])).astype(float)[..., 0]
    kept = _kept_share(0.5 * (levels[:, 1:] ** 2).sum(axis=-1), error)
    tilt: Array = kept[:, None] * (levels[:, 1:] @ rows[:, 1:].T)
    return levels[:, :1], tilt, kept


def _local(values: Array, mask: Mask, error: Array) -> tuple[Array, Array]:
    """Mean plus shrunk deviations (K, T), smoothed over a sixteenth turn, and their kept share (K,).

    `error` (K,) is the variance of a harmonic's amplitude over the whole turn.
    """
    near = _neighbours(values.shape[1])
    n_seen = np.maximum(mask.sum(axis=-1), 1)
    mean = (mask * values).sum(axis=-1, keepdims=True) / n_seen[:, None]
    smooth = (np.where(mask, values - mean, 0.0) @ near) / np.maximum(mask @ near, 1.0)
    share = near[0].sum() / len(near)
    kept = _kept_share((mask * smooth**2).sum(axis=-1) / n_seen, 0.5 * error / share)
    return mean + kept[:, None] * smooth, kept


def _kept_share(power: Array, error: Array) -> Array:
    """(K,) share that is kept of estimated departures, given their mean square and that of their error (K,)."""
    true_power = max(float((power - error).mean()), 0.0)
    return true_power / np.maximum(true_power + error, 1e-12)


@lru_cache(maxsize=64)
def _harmonics(T: int) -> Array:
    """(T, 3) constant, cosine and sine on a circle."""
    angle = 2.0 * np.pi * np.arange(T) / T
    return np.stack([np.ones(T), np.cos(angle), np.sin(angle)], axis=-1)


@lru_cache(maxsize=64)
def _neighbours(T: int) -> Array:
    """(T, T) ones where two places of a circle are within a thirty-second of a turn."""
    lag = np.abs(np.arange(T)[:, None] - np.arange(T))
    return (np.minimum(lag, T - lag) <= max(1, T // 32)).astype(float)
