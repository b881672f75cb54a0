"""Where discs may be: outlines of red blobs in a half-size picture, at several levels, with a first ellipse each.

The half-size picture makes the search cheap and averages noise; red less the larger of green and blue keeps white and
grey things out of it at once. A picture without colour is searched in its red channel instead. Each blob is found at
the level that lies nearest to half its height, where blur does not move its outline.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TypeVar

import cv2
import numpy as np
from numpy.typing import NDArray

from armtwin.calib.markers.disc import Array, DetectorConfig, Image
from armtwin.models.errors import InputError

# Levels a factor of 1.6 apart: one of them lies between 0.4 and 0.63 of any blob's height.
_LEVEL_RATIO = 1.6
# Logarithm of a level over half a blob's height, beyond which the blob is noise on something that just reaches it.
_MOST_MISFIT = 0.5
# A picture whose redness stays below this nowhere shows colour (grey levels; noise of 8 leaves 4 in the half picture).
_COLOURLESS = 40
# The most candidates that are measured, largest share of a disc's shape first; a picture of clutter stays affordable.
_MOST = 24
# Share of an outline that must lie on one circle for a blob to be tried at all.
_LEAST_INLIERS = 0.3


_Number = TypeVar("_Number", float, Array)


@dataclass(frozen=True)
class CandidateDisc:
    """A blob that may be a disc: centre (2,), shape (2, 2) of its ellipse `centre + shape @ (cos t, sin t)`, raw px."""

    centre: Array
    shape: Array
    score: float

    @property
    def radius(self) -> float:
        """Geometric mean of the semi-axes, px."""
        return _radius(self.shape)


def red_channel(image: Image) -> Image:
    """Return the red channel (a view) of a BGR picture, or a grey picture itself; raises `InputError`."""
    if image.dtype != np.uint8 or image.ndim not in (2, 3) or (image.ndim == 3 and image.shape[2] != 3):
        raise InputError(f"picture: expected (H, W, 3) BGR or (H, W) grey, 8 bits; found {image.shape} {image.dtype}")
    return image[..., 2] if image.ndim == 3 else image


def find_candidates(image: Image, config: DetectorConfig) -> list[CandidateDisc]:
    """Return the blobs of a picture that may be discs, likeliest first."""
    signal = _search_picture(image)
    candidates = [_first_ellipse(blob.outline) for blob in _distinct_blobs(signal, config)]
    usable = [c for c in candidates if c is not None and _is_disc_sized(c, config)]
    return sorted(usable, key=lambda c: -c.score)[:_MOST]


def _search_picture(image: Image) -> Image:
    """Half-size, lightly smoothed picture of redness, or of the red channel where there is no colour."""
    red_channel(image)
    half = cv2.resize(image, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)
    if half.ndim == 3:
        blue, green, red = cv2.split(half)
        redness = cv2.subtract(red, cv2.max(green, blue))
        half = redness if redness.max() >= _COLOURLESS else red
    return np.asarray(cv2.GaussianBlur(half, (3, 3), 0), dtype=np.uint8)


@dataclass(frozen=True)
class _Blob:
    """An outline (P, 1, 2) in the half-size picture with its box's middle and size, and how ill its level fits."""

    outline: NDArray[np.int32]
    x: float
    y: float
    size: float
    misfit: float


def _distinct_blobs(signal: Image, config: DetectorConfig) -> list[_Blob]:
    """Blobs of about a disc's size, each at the level nearest to half its height."""
    found: list[_Blob] = []
    level, top = config.min_contrast, float(signal.max())
    while level < top:
        _, binary = cv2.threshold(signal, level, 255, cv2.THRESH_BINARY)
        outlines, _ = cv2.findContours(binary, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
        for outline in outlines:
            left, upper, width, height = cv2.boundingRect(outline)
            # Half-size: a disc's box is as wide as its radius in px, less a pixel for the outline's own width.
            size = max(width, height)
            if len(outline) < 4 or not config.min_radius_px - 2.0 <= size <= 1.5 * config.max_radius_px:
                continue
            x, y = left + 0.5 * (width - 1), upper + 0.5 * (height - 1)
            misfit = abs(math.log(2.0 * level / max(float(signal[round(y), round(x)]), level)))
            if misfit < _MOST_MISFIT:
                found.append(_Blob(np.asarray(outline, dtype=np.int32), x, y, size, misfit))
        level *= _LEVEL_RATIO
    kept: list[_Blob] = []
    for blob in sorted(found, key=lambda b: b.misfit):
        if all(math.hypot(blob.x - k.x, blob.y - k.y) > 0.3 * min(blob.size, k.size) for k in kept):
            kept.append(blob)
    return kept


def _first_ellipse(outline: NDArray[np.int32]) -> CandidateDisc | None:
    """First ellipse of an outline, or None where too little of it lies on any."""
    points = outline[:, 0].astype(float)
    ellipse = _whole_outline(points, outline) or _part_of_outline(points)
    if ellipse is None:
        return None
    centre, shape, score = ellipse
    # An outline runs through the outermost pixels' centres, so that the edge is nearly half a pixel outside.
    shape = shape * (1.0 + 0.45 / _radius(shape))
    return CandidateDisc(2.0 * centre + 0.5, 2.0 * shape, score)


def _is_disc_sized(candidate: CandidateDisc, config: DetectorConfig) -> bool:
    # The measurement decides; a first radius may be a pixel off.
    return config.min_radius_px - 1.0 <= candidate.radius <= config.max_radius_px + 1.0


def _radius(shape: Array) -> float:
    return max(math.sqrt(abs(shape[0, 0] * shape[1, 1] - shape[0, 1] * shape[1, 0])), 0.5)


def _tolerance(radius: _Number) -> _Number:
    """Distance from a first ellipse at which an outline's pixel still belongs to it, half-size px."""
    return 0.8 + 0.03 * radius


def _whole_outline(points: Array, outline: NDArray[np.int32]) -> tuple[Array, Array, float] | None:
    """Ellipse of the outline's second moments where all of the outline lies on it."""
    moments = cv2.moments(outline)
    if moments["m00"] < 3.0:
        centre = points.mean(axis=0)
        radius = max(0.5 * float(np.ptp(points, axis=0).mean()), 0.7)
        return centre, radius * np.eye(2), 0.5
    area = moments["m00"]
    centre = np.array([moments["m10"], moments["m01"]]) / area
    second = np.array([[moments["mu20"], moments["mu11"]], [moments["mu11"], moments["mu02"]]]) / area
    shape = _square_root(4.0 * second)  # a disc's second moment is r^2 / 4
    inliers = _inliers(points, centre, shape)
    return (centre, shape, inliers) if inliers > 0.95 else None


def _square_root(matrix: Array) -> Array:
    """Square root of a symmetric 2 x 2 matrix, by Cayley and Hamilton."""
    root = math.sqrt(max(matrix[0, 0] * matrix[1, 1] - matrix[0, 1] ** 2, 1e-9))
    square_root: Array = (matrix + root * np.eye(2)) / math.sqrt(matrix[0, 0] + matrix[1, 1] + 2.0 * root)
    return square_root


def _inliers(points: Array, centre: Array, shape: Array) -> float:
    """Share of the points that lie on an ellipse."""
    radius = _radius(shape)
    on_circle = (points - centre) @ np.linalg.inv(shape)
    distance = (np.hypot(on_circle[:, 0], on_circle[:, 1]) - 1.0) * radius
    return float(np.count_nonzero(np.abs(distance) < _tolerance(radius))) / len(points)


def _part_of_outline(points: Array) -> tuple[Array, Array, float] | None:
    """Circle that most of a broken outline lies on, by drawing triples of its points (RANSAC)."""
    n = len(points)
    draw = np.random.default_rng(n).integers(0, n, size=(96, 3))  # seeded: the same picture gives the same discs
    p, q, r = (points[draw[:, i]] for i in range(3))
    u, v = q - p, r - p
    twice_area = 2.0 * (u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])
    usable = np.abs(twice_area) > 2.0
    if not usable.any():
        return None
    p, u, v, twice_area = p[usable], u[usable], v[usable], twice_area[usable]
    uu, vv = (u * u).sum(axis=1), (v * v).sum(axis=1)
    offset: Array = np.stack([v[:, 1] * uu - u[:, 1] * vv, u[:, 0] * vv - v[:, 0] * uu], axis=1) / twice_area[:, None]
    radius: Array = np.sqrt((offset**2).sum(axis=1))
    distance = np.abs(np.linalg.norm(points[None] - (p + offset)[:, None], axis=2) - radius[:, None])
    inside = distance < _tolerance(radius)[:, None]
    # Points per length of the circle: else a huge circle along a straight side would beat the true arc.
    share = inside.sum(axis=1) / np.maximum(2.0 * np.pi * radius, n)
    best = int(np.argmax(share))
    if share[best] < _LEAST_INLIERS:
        return None
    centre: Array = p[best] + offset[best]
    return centre, float(radius[best]) * np.eye(2), float(share[best])
