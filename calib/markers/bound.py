"""The Cramer-Rao bound: how well any unbiased detector can know a disc's centre from one picture.

A disc of radius r and contrast C on even ground, blurred by a Gaussian of standard deviation s, changes by
g(n) cos(t) per unit of displacement in u at the distance n from its edge and the angle t, where g is the Gaussian of
area C. With white noise of variance v a pixel, the Fisher information of u is the integral of (g cos t)^2 / v over the
picture: pi r C^2 / (2 sqrt(pi) s v). By symmetry u is uncorrelated with v, radius, contrast and blur, so its inverse is
the bound also where these are not known. (A linear shading that is not known would raise it.)
"""

from __future__ import annotations

import math

# Variance of a place within a pixel, px^2: the pixel integrates the light over its width.
_PIXEL_VARIANCE = 1.0 / 12.0
# Variance of rounding to whole grey levels.
_ROUNDING_VARIANCE = 1.0 / 12.0


def centre_bound(radius_px: float, contrast: float, blur_px: float, noise: float) -> float:
    """Return the least standard deviation of a centre coordinate, px.

    `contrast` and `noise` (standard deviation of a pixel before rounding) are in grey levels of an 8-bit picture;
    `blur_px` is the optical blur's standard deviation, to which the pixel's width is added. Holds for discs that are
    several blurs wide.
    """
    blur = math.sqrt(blur_px**2 + _PIXEL_VARIANCE)
    variance = noise**2 + _ROUNDING_VARIANCE
    return math.sqrt(2.0 * blur * variance / (math.sqrt(math.pi) * radius_px)) / contrast
