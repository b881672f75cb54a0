"""Pictures that must not be measured: black, over-exposed or blurred. (Frozen streams are the webcam's to notice.)"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from armtwin.hardware.bench.tables import QualityTable
from armtwin.hardware.camera.stillness import Grey

# A channel at 250 of 255 is as good as clipped behind a JPEG's rounding.
_SATURATED_LEVEL = 250
# Contrast around an edge is looked for this far to both sides: wider than the widest blur that is told from none.
_REACH_PX = 10
# The strongest gradients: about as many pixels as three stickers have on their rims, at 720p.
_EDGE_SHARE = 3e-4
# Scharr's weights sum to 32 a pixel.
_SCHARR_SCALE = 1.0 / 32.0
# Candidates' slopes in half grey levels a pixel; 128 levels a pixel and more are all steep.
_CANDIDATE_SCALE = 1.0 / 16.0
_CANDIDATES_EACH = 6
# Edges lower than this many grey levels say nothing about the lens.
_MIN_CONTRAST = 20.0


def brightness(grey: Grey) -> float:
    """99.5th percentile of the grey levels: what the bright parts reach, dark as the scene may be."""
    counts = np.cumsum(cv2.calcHist([grey], [0], None, [256], [0, 256]))
    return float(np.searchsorted(counts, 0.995 * grey.size))


def saturated_share(grey: Grey) -> float:
    """Share of pixels that are clipped."""
    return float(np.count_nonzero(grey >= _SATURATED_LEVEL)) / grey.size


def edge_width_px(grey: Grey) -> float:
    """Median width of the steepest edges, px: contrast over slope; infinite for a picture without edges.

    An ideal step through an area-averaging pixel has about 1 to 2, a Gaussian blur of sigma has sigma * sqrt(2 pi).
    The picture's contrast does not matter, and its noise little, since only the steepest edges are looked at.
    """
    smooth = cv2.GaussianBlur(grey, (3, 3), 0)
    dx, dy = cv2.Scharr(smooth, cv2.CV_16S, 1, 0), cv2.Scharr(smooth, cv2.CV_16S, 0, 1)
    # Candidates by |dx| + |dy| in eight bits, a quarter of the time of the true slope, which only they are given.
    steep = cv2.add(cv2.convertScaleAbs(dx, alpha=_CANDIDATE_SCALE), cv2.convertScaleAbs(dy, alpha=_CANDIDATE_SCALE))
    counts = cv2.calcHist([steep], [0], None, [256], [0, 256]).ravel()
    n = max(20, int(_EDGE_SHARE * grey.size))
    enough = np.cumsum(counts[::-1]) >= _CANDIDATES_EACH * n  # steepest first
    # One flat index: a third of the time of one for rows and columns.
    rows, columns = np.divmod(np.flatnonzero(steep >= max(1, 255 - int(np.argmax(enough)))), grey.shape[1])
    slope = np.hypot(dx[rows, columns], dy[rows, columns], dtype=np.float64) * _SCHARR_SCALE
    steepest = np.argsort(slope)[-n:]
    rows, columns, slope = rows[steepest], columns[steepest], slope[steepest]
    framed = cv2.copyMakeBorder(smooth, _REACH_PX, _REACH_PX, _REACH_PX, _REACH_PX, cv2.BORDER_REPLICATE)
    around = sliding_window_view(framed, (2 * _REACH_PX + 1, 2 * _REACH_PX + 1))[rows, columns]
    contrast = np.ptp(around, axis=(1, 2)).astype(np.float64)
    useful = contrast >= _MIN_CONTRAST
    if not useful.any():
        return float("inf")
    return float(np.median(contrast[useful] / slope[useful]))


def fault_of(grey: Grey, bounds: QualityTable) -> str | None:
    """Say what is wrong with an (H, W) picture and what to do, or None if it may be measured."""
    bright = brightness(grey)
    if bright < bounds.min_brightness:
        return f"the picture is black (brightest parts at {bright:.0f} of 255); take the cap off, switch on the light"
    clipped = saturated_share(grey)
    if clipped > bounds.max_saturated_share:
        return f"the picture is over-exposed ({100 * clipped:.0f} % clipped); lower camera.exposure or dim the light"
    width = edge_width_px(grey)
    if width > bounds.max_edge_px:
        found = f"its sharpest edges are {width:.1f} px wide" if np.isfinite(width) else "no edges in it"
        return f"the picture is blurred ({found}); set camera.focus, clean the lens"
    return None
