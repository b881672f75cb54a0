"""The noise of one scalar observation, declared or estimated from what no smooth cause can move."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from armtwin.calib.diagnosis.problem import Problem
from armtwin.models.statistics import MAD_TO_STD

Array = NDArray[np.float64]

# Median absolute deviation of a Gaussian to its standard deviation.
# Angles read off a scale or an encoder are no better than this, and a noise of zero would make every test infinite.
_LEAST_NOISE_RAD = 1e-5
_LEAST_NOISE_PX = 1e-3
# Fewer values than this give no spread.
_LEAST_DIFFERENCES = 8


# Values beyond three standard deviations are clipped there; a Gaussian then keeps this part of its own.
_CLIP = 3.0
_CLIPPED_STD = 0.9974
# The quietest of several estimates is low by chance; only one that is this much quieter than marker A is believed.
_CLEARLY = 1.25


def robust_std(values: Array) -> float:
    """Standard deviation about zero by the median of absolute values; NaN is left out."""
    return float(MAD_TO_STD * np.nanmedian(np.abs(values)))


def least_noise(problem: Problem) -> float:
    """Return the smallest noise that is believed, in the channels' unit."""
    return max(problem.grain_std, _LEAST_NOISE_PX if problem.is_pixels else _LEAST_NOISE_RAD)


def clipped_std(values: Array, least: float = 0.0) -> float:
    """Standard deviation about zero of Gaussian values with a few gross ones; nearly as efficient as without them.

    `least` is what it cannot be below: of coarse values most may be alike, and their median says nothing.
    """
    limit = _CLIP * max(robust_std(values), least)
    clipped = np.clip(values, -limit, limit)
    return float(np.sqrt(np.nanmean(clipped * clipped))) / _CLIPPED_STD if limit > 0 else 0.0


def estimate_noise(problem: Problem, residual: Array) -> float:
    """Noise of a recording that declares none, in the channels' unit, from the residual (N, M, d) of its geometry.

    Marker A does not move, so that what it does from one picture to the next is noise. Elsewhere second differences of
    the residual cancel what varies smoothly; rough causes raise them. Marker A is believed unless another channel is
    clearly quieter; without it, the quietest channel.
    """
    each = [channel_noise(problem, residual, channel) for channel in range(residual.shape[1])]
    estimates = [one for one in each if np.isfinite(one)]
    quietest = min(estimates, default=robust_std(residual))
    first = each[0] if np.isfinite(each[0]) and problem.is_pixels and problem.channels[0] == "a" else quietest
    noise = first if first < _CLEARLY * quietest else quietest
    return max(noise, least_noise(problem))


def channel_noise(problem: Problem, residual: Array, channel: int) -> float:
    """Noise of one channel by what its residual (N, M, d) does from one pose to the next; NaN of too few poses."""
    # Poses kept back, or not seen, must not tear the sequence: with every fourth left out no three stand together.
    seen = residual[np.isfinite(residual[:, channel]).all(axis=-1), channel]
    at_rest = problem.is_pixels and problem.channels[channel] == "a"
    change = seen[1:] - seen[:-1] if at_rest else seen[2:] - 2.0 * seen[1:-1] + seen[:-2]
    if change.size < _LEAST_DIFFERENCES:
        return float("nan")
    summed = np.sqrt(2.0 if at_rest else 6.0)
    return clipped_std(change, summed * problem.grain_std) / float(summed)
