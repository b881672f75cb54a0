"""Where discs may be: outlines of red blobs in a half-size picture, at several levels, with a first ellipse each.

The half-size picture makes the search cheap and averages noise; red less the larger of green and blue keeps white and
grey things out of it at once. A picture without colour is searched in its red channel instead. Each blob is found at
the level that lies nearest to half its height, where blur does not move its outline.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from calib.markers.disc import Array, DetectorConfig, Image
from models.errors import InputError

# Levels a factor of 1.5 apart: one of them lies between 0.41 and 0.61 of any blob's height.
_LEVEL_RATIO = 1.5
# A picture whose redness stays below this nowhere shows colour (grey levels; noise of 8 leaves 4 in the half picture).
_COLOURLESS = 40
# The most candidates that are measured, largest share of a disc's shape first; a picture of clutter stays affordable.
_MOST = 24
# Share of an outline that must lie on one circle for a blob to be tried at all.
_LEAST_INLIERS = 0.3


@dataclass(frozen=True)
class Candidate:
    """A blob that may be a disc: centre (2,), shape (2, 2) of its ellipse `centre + shape @ (cos t, sin t)`, raw px."""

    centre: Array
    shape: Array
    score: float

    @property
    def radius(self) -> float:
        """Geometric mean of the semi-axes, px."""
        return float(np.sqrt(np.linalg.det(self.shape)))


def red_channel(image: Image) -> Image:
    """Return the red channel (a view) of a BGR picture, or a grey picture itself; raises `InputError`."""
    if image.dtype != np.uint8 or image.ndim not in (2, 3) or (image.ndim == 3 and image.shape[2] != 3):
        raise InputError(f"picture: expected (H, W, 3) BGR or (H, W) grey, 8 bits; found {image.shape} {image.dtype}")
    return image[..., 2] if image.ndim == 3 else image


def find_candidates(image: Image, config: DetectorConfig) -> list[Candidate]:
    """Return the blobs of a picture that may be discs, likeliest first."""
    signal = _search_picture(image)
    found: list[tuple[float, Candidate]] = []
    for level in _levels(signal, config.min_contrast):
        _, binary = cv2.threshold(signal, level, 255, cv2.THRESH_BINARY)
        outlines, _ = cv2.findContours(binary, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
        for outline in outlines:
            candidate = _candidate(outline, config)
            if candidate is not None:
                found.append((_level_fit(signal, candidate, level), candidate))
    return _distinct(found)[:_MOST]


def _search_picture(image: Image) -> Image:
    """Half-size, lightly smoothed picture of redness, or of the red channel where there is no colour."""
    red_channel(image)
    half = cv2.resize(image, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)
    if half.ndim == 3:
        blue, green, red = cv2.split(half)
        redness = cv2.subtract(red, cv2.max(green, blue))
        half = redness if int(redness.max()) >= _COLOURLESS else red
    smooth: Image = cv2.GaussianBlur(half, (3, 3), 0)
    return smooth


def _levels(signal: Image, lowest: float) -> list[float]:
    top = float(signal.max())
    n = max(0, int(np.ceil(np.log(max(top / lowest, 1.0)) / np.log(_LEVEL_RATIO))))
    return [lowest * _LEVEL_RATIO**i for i in range(n)]


def _candidate(outline: NDArray[np.int32], config: DetectorConfig) -> Candidate | None:
    """First ellipse of one outline in the half-size picture, or None where it can be no disc."""
    _, _, width, height = cv2.boundingRect(outline)
    # An outline runs through the outermost pixels' centres, so a disc of radius r (whole px) is about r - 1 wide here.
    if max(width, height) < config.min_radius_px - 1 or min(width, height) > config.max_radius_px + 4:
        return None
    points = outline[:, 0].astype(float)
    if len(points) < 6:
        return None
    ellipse = _whole_outline(points, outline) or _part_of_outline(points)
    if ellipse is None:
        return None
    centre, shape, inliers = ellipse
    shape = shape + 0.4 * shape / max(np.sqrt(abs(np.linalg.det(shape))), 1e-6)  # inner pixels: the edge is outside
    candidate = Candidate(2.0 * centre + 0.5, 2.0 * shape, inliers)
    axes = np.linalg.eigvalsh(candidate.shape)
    if not config.min_radius_px <= candidate.radius <= config.max_radius_px or axes[0] < 0.5 * axes[1]:
        return None
    return candidate


def _tolerance(radius: float) -> float:
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
    values, vectors = np.linalg.eigh(matrix)
    root: Array = (vectors * np.sqrt(np.maximum(values, 1e-9))) @ vectors.T
    return root


def _inliers(points: Array, centre: Array, shape: Array) -> float:
    radius = np.sqrt(abs(np.linalg.det(shape)))
    distance = (np.linalg.norm(np.linalg.solve(shape, (points - centre).T), axis=0) - 1.0) * radius
    return float((np.abs(distance) < _tolerance(radius)).mean())


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
    offset = np.stack([v[:, 1] * uu - u[:, 1] * vv, u[:, 0] * vv - v[:, 0] * uu], axis=1) / twice_area[:, None]
    radius = np.linalg.norm(offset, axis=1)
    distance = np.abs(np.linalg.norm(points[None] - (p + offset)[:, None], axis=2) - radius[:, None])
    inside = distance < _tolerance(radius)[:, None]
    # Points per length of the circle: else a huge circle along a straight side would beat the true arc.
    share = inside.sum(axis=1) / np.maximum(2.0 * np.pi * radius, n)
    best = int(np.argmax(share))
    if share[best] < _LEAST_INLIERS:
        return None
    return (p + offset)[best], radius[best] * np.eye(2), float(share[best])


def _level_fit(signal: Image, candidate: Candidate, level: float) -> float:
    """How far the level is from half the blob's height, as the logarithm of their ratio."""
    column, row = np.clip(np.rint(0.5 * (candidate.centre - 0.5)), 0, np.array(signal.shape[::-1]) - 1).astype(int)
    height = max(float(signal[row, column]), 1.0)
    return abs(float(np.log(2.0 * level / height)))


def _distinct(found: list[tuple[float, Candidate]]) -> list[Candidate]:
    """Keep one candidate of those that overlap, the one found nearest to half its height; likeliest first."""
    kept: list[Candidate] = []
    for _, candidate in sorted(found, key=lambda item: item[0]):
        if all(np.linalg.norm(candidate.centre - k.centre) > 0.6 * max(candidate.radius, k.radius) for k in kept):
            kept.append(candidate)
    return sorted(kept, key=lambda c: -c.score)
