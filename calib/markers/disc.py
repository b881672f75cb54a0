"""What a detector reports of one disc, and the settings that both detectors share."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Image = NDArray[np.uint8]
Method = Literal["subpixel", "paper"]


@dataclass(frozen=True, eq=False)
class Disc:
    """One disc found in a picture.

    Attributes:
        centre: (2,) raw (distorted) pixels: the image of the disc's centre where the camera is known, else the
            centre of its outline.
        covariance: (2, 2) px^2 of the centre from the scatter of the edge points; NaN from the paper's method,
            which gives none.
        axes: (2,) semi-axes of the outline, px, the longer first.
        contrast: grey levels between face and ground, in the red channel.
        blur_px: standard deviation of the edge's Gaussian profile, px, the pixel's own width included.
        coverage: share of the outline that was seen as a clean edge, 0 to 1.
        edges: (E, 2) the edge points that the fit kept, raw pixels.

    """

    centre: Array
    covariance: Array
    axes: Array
    contrast: float
    blur_px: float
    coverage: float
    edges: Array

    @property
    def is_whole(self) -> bool:
        """Whether so much of the outline was seen that the centre needs no help from the assumed shape."""
        return self.coverage >= WHOLE


# Share of the outline from which a disc counts as wholly seen: what one thin cable across it leaves.
WHOLE = 0.9


@dataclass(frozen=True)
class DetectorConfig:
    """Settings of both detectors.

    Attributes:
        min_radius_px, max_radius_px: discs outside this range are clutter.
        min_contrast: grey levels in the red channel, below which nothing is taken for a disc.
        min_coverage: share of the outline that must be seen.

    """

    min_radius_px: float = 3.0
    max_radius_px: float = 60.0
    min_contrast: float = 20.0
    min_coverage: float = 0.4
