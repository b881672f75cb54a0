"""Lab 2: a frame of the bench, and small pictures of one disc whose true centre is known."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from armtwin.calib.markers.disc import Image
from armtwin.calib.markers.paper import detect_paper, paper_stages

Array = NDArray[np.float64]

# What the arm's markers look like in Table 2's picture.
RADIUS_PX, FACE, GROUND, BLUR_PX, NOISE = 21.0, 190.0, 40.0, 1.2, 2.5
_SIDE_PX, _FINE, _SEED = 72, 4, 21
# Along a normal: a sample a pixel, from inside to outside.
REACH_PX = 7

# Table 3: true length and average measurement, mm; the scale of the picture in the arm's plane.
LENGTHS_MM = np.array([40.0, 30.0, 10.0, 5.0])
MEASURED_MM = np.array([40.2301, 30.2279, 10.2029, 5.2320])
MM_PER_PX = 0.337


@dataclass(frozen=True, eq=False)
class Photograph:
    """A grey picture (H, W) of one disc and its true centre (2,), px."""

    image: Image
    centre: Array


def figure_3(frame: Image) -> dict[str, Image]:
    """Return the stages of the paper's Figure 3 in a picture of the bench, by name."""
    stages = paper_stages(frame)
    return {
        "red channel": stages.red,
        "smoothed": stages.smooth,
        "gradient in u": stages.gradient_u,
        "gradient in v": stages.gradient_v,
        "gradient": stages.gradient,
        "binary": stages.binary,
        "opened": stages.opened,
    }


@cache
def photographs(n: int = 60) -> tuple[Photograph, ...]:
    """Return pictures of one disc each, somewhere near the middle, blurred and noisy."""
    rng = np.random.default_rng(_SEED)
    return tuple(_photograph(0.5 * (_SIDE_PX - 1) + rng.uniform(-2, 2, 2), rng) for _ in range(n))


def hough_centre(image: Image) -> Array:
    """(2,) centre that the paper's chain finds, px; NaN where it finds none."""
    found = detect_paper(image)
    return found[0].centre if found else np.full(2, np.nan)


def rough_centre(image: Image) -> Array:
    """(2,) mean place of the bright pixels: good to a fraction of a pixel, to start from."""
    v, u = np.nonzero(image > 0.5 * (FACE + GROUND))
    return np.array([u.mean(), v.mean()])


def read_normals(image: Image, centre: Array, radius_px: float = RADIUS_PX, n: int = 90) -> tuple[Array, Array, Array]:
    """Return grey levels (n, S) along n normals of a circle, the distances (S,) from it, and the directions (n, 2)."""
    angle = np.arange(n) * (2 * np.pi / n)
    directions = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    x = np.arange(-REACH_PX, REACH_PX + 1.0)
    at = centre + (radius_px + x)[None, :, None] * directions[:, None]
    whole = np.floor(at).astype(int)
    fu, fv = np.moveaxis(at - whole, -1, 0)
    u, v = np.moveaxis(whole, -1, 0)
    grey = image.astype(float)
    upper = grey[v, u] * (1 - fu) + grey[v, u + 1] * fu
    lower = grey[v + 1, u] * (1 - fu) + grey[v + 1, u + 1] * fu
    return upper * (1 - fv) + lower * fv, x, directions


def _photograph(centre: Array, rng: np.random.Generator) -> Photograph:
    fine = (np.arange(_SIDE_PX * _FINE) + 0.5) / _FINE - 0.5
    u, v = np.meshgrid(fine, fine)
    share = np.clip(0.5 - (np.hypot(u - centre[0], v - centre[1]) - RADIUS_PX) * _FINE, 0.0, 1.0)
    share = gaussian_filter(share, BLUR_PX * _FINE).reshape(_SIDE_PX, _FINE, _SIDE_PX, _FINE).mean(axis=(1, 3))
    levels = GROUND + (FACE - GROUND) * share + rng.normal(0, NOISE, share.shape)
    return Photograph(np.clip(np.rint(levels), 0, 255).astype(np.uint8), centre)
