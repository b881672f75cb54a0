"""The noise of one scalar observation, declared or estimated from what no smooth cause can move."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from calib.diagnosis.problem import Problem

Array = NDArray[np.float64]

# Median absolute deviation of a Gaussian to its standard deviation.
MAD_TO_STD = 1.4826
# Angles read off a scale or an encoder are no better than this, and a noise of zero would make every test infinite.
_LEAST_NOISE_RAD = 1e-5
_LEAST_NOISE_PX = 1e-3
# Fewer values than this give no spread.
_LEAST_DIFFERENCES = 8


def robust_std(values: Array) -> float:
    """Standard deviation about zero by the median of absolute values; NaN is left out."""
    return float(MAD_TO_STD * np.nanmedian(np.abs(values)))


def least_noise(problem: Problem) -> float:
    """Return the smallest noise that is believed, in the channels' unit."""
    return _LEAST_NOISE_PX if problem.is_pixels else _LEAST_NOISE_RAD


def estimate_noise(problem: Problem, residual: Array) -> float:
    """Noise of a recording that declares none, in the channels' unit, from the residual (N, M, d) of its geometry.

    Marker A does not move, so that what it does from one picture to the next is noise. Elsewhere second differences of
    the residual cancel what varies smoothly; rough causes raise them, so the quietest channel is believed.
    """
    estimates = []
    if problem.is_pixels and problem.channels[0] == "a":
        steps = np.diff(problem.observed[:, 0], axis=0)
        if np.isfinite(steps).sum() >= 16:
            estimates.append(robust_std(steps) / np.sqrt(2.0))
    for channel in range(residual.shape[1]):
        # Poses kept back, or not seen, must not tear the sequence: with every fourth left out no three stand together.
        seen = residual[np.isfinite(residual[:, channel]).all(axis=-1), channel]
        second = seen[2:] - 2.0 * seen[1:-1] + seen[:-2]
        if second.size >= _LEAST_DIFFERENCES:
            estimates.append(robust_std(second) / np.sqrt(6.0))
    return max(min(estimates, default=robust_std(residual)), least_noise(problem))
