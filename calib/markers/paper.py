"""The paper's detector (section 3.2, Figure 3), every stage viewable.

Red channel, Gaussian smoothing, Sobel in u and v, gradient magnitude, threshold, morphological opening, circular Hough
transform; the Hough circles' centres are the measurement. The paper gives no sizes or thresholds: those below are ours.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from armtwin.calib.markers.candidates import red_channel
from armtwin.calib.markers.disc import Array, DetectorConfig, Disc, Image

# Standard deviation of the smoothing, px: the least that hides sensor noise of a few grey levels from Sobel.
_SMOOTHING_PX = 1.5
# Share of the strongest gradient at which the gradient is made binary.
_THRESHOLD = 0.35
# Opening by 3 x 3 removes what is thinner: isolated points, not the outlines, which smoothing has made 4 px wide.
_OPENING = np.ones((3, 3), np.uint8)
# Radii that are sought unless told: the arm's discs of 7 mm are 21 px in Table 2's picture.
_ARM_MARKERS = DetectorConfig(min_radius_px=12.0, max_radius_px=32.0)
# Votes that a circle needs in the accumulator: fewer are chance crossings of other outlines' gradients.
_VOTES = 12.0
# Upper threshold of the edge detection that OpenCV's transform runs on the binary picture; any value finds its edges.
_EDGE_THRESHOLD = 100.0


@dataclass(frozen=True, eq=False)
class PaperStages:
    """What Figure 3 shows: one picture (H, W) 8 bits a stage, and the circles found in the last.

    `gradient_u`, `gradient_v` are magnitudes; all gradients are scaled so that the strongest is white. `circles` is
    (M, 3): centre and radius, px.
    """

    red: Image
    smooth: Image
    gradient_u: Image
    gradient_v: Image
    gradient: Image
    binary: Image
    opened: Image
    circles: Array


def detect_paper(image: Image, config: DetectorConfig | None = None) -> tuple[Disc, ...]:
    """Return the Hough circles of a BGR or grey picture as discs, from left to right; see `markers.detect`."""
    config = config or _ARM_MARKERS
    stages = paper_stages(image, config)
    discs = [_disc(stages.red, circle) for circle in stages.circles]
    bright = [disc for disc in discs if disc.contrast >= config.min_contrast]
    return tuple(sorted(bright, key=lambda disc: float(disc.centre[0])))


def _disc(red: Image, circle: Array) -> Disc:
    """Disc of a circle (3,), its contrast read in its middle and on a ring around it."""
    angle = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
    unit = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    inside, around = (_nearest(red, circle[:2] + share * circle[2] * unit) for share in (0.5, 1.25))
    return Disc(
        centre=circle[:2],
        covariance=np.full((2, 2), np.nan),
        axes=np.array([circle[2], circle[2]]),
        contrast=float(np.median(inside)) - float(np.median(around)),
        blur_px=float("nan"),
        coverage=float("nan"),
        edges=np.empty((0, 2)),
    )


def _nearest(red: Image, points: Array) -> Image:
    """Grey levels of the pixels nearest to (N, 2) points, those outside moved to the border."""
    column, row = np.clip(np.rint(points), 0, np.array(red.shape[::-1]) - 1).astype(int).T
    return red[row, column]


def paper_stages(image: Image, config: DetectorConfig | None = None) -> PaperStages:
    """Run the chain of Figure 3 on a BGR or grey picture and keep every stage."""
    config = config or _ARM_MARKERS
    red = np.ascontiguousarray(red_channel(image))
    smooth = cv2.GaussianBlur(red, (0, 0), _SMOOTHING_PX)
    gradient_u = cv2.Sobel(smooth, cv2.CV_32F, 1, 0)
    gradient_v = cv2.Sobel(smooth, cv2.CV_32F, 0, 1)
    gradient = cv2.magnitude(gradient_u, gradient_v)
    strongest = max(float(gradient.max()), 1.0)
    _, binary = cv2.threshold(gradient, _THRESHOLD * strongest, 255.0, cv2.THRESH_BINARY)
    binary = binary.astype(np.uint8)
    opened = cv2.morphologyEx(binary, cv2.MORPH_OPEN, _OPENING)
    scale = 255.0 / strongest
    return PaperStages(
        red=red,
        smooth=_image(smooth),
        gradient_u=_image(cv2.convertScaleAbs(gradient_u, alpha=scale)),
        gradient_v=_image(cv2.convertScaleAbs(gradient_v, alpha=scale)),
        gradient=_image(cv2.convertScaleAbs(gradient, alpha=scale)),
        binary=_image(binary),
        opened=_image(opened),
        circles=_circles(_image(opened), config),
    )


def _image(matrix: object) -> Image:
    return np.asarray(matrix, dtype=np.uint8)


def _circles(opened: Image, config: DetectorConfig) -> Array:
    """(M, 3) centre and radius of the circles, strongest first; none has its centre inside a stronger one."""
    found = cv2.HoughCircles(
        opened,
        cv2.HOUGH_GRADIENT,
        dp=1.0,
        minDist=config.min_radius_px,
        param1=_EDGE_THRESHOLD,
        param2=_VOTES,
        minRadius=int(config.min_radius_px),
        maxRadius=int(config.max_radius_px),
    )
    kept: list[Array] = []
    for circle in np.empty((0, 3)) if found is None else np.asarray(found, dtype=float).reshape(-1, 3):
        if all(np.hypot(*(circle[:2] - k[:2])) > max(circle[2], k[2]) for k in kept):
            kept.append(circle)
    return np.array(kept).reshape(-1, 3)
