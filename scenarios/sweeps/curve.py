"""How the share of recordings in which a fault is found grows with its size, where some are missed however large.

P(found | size) = (1 - lapse) Phi((log size - middle) / width), the psychometric function with a lapse (F. Wichmann and
N. Hill, Perception & Psychophysics 63, 2001), with its posterior on a grid: no start, no failure to converge, and every
band is a quantile.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import stats

Array = NDArray[np.float64]

_MIDDLES, _WIDTHS, _LAPSES = 81, 13, 9
# Width of the rise in the logarithm of the size: from a step to a slope over two decades.
_WIDTH = (0.05, 1.6)
# A lapse is rare: Beta(1, 8) has a mean of one in nine.
_LAPSE_PRIOR = (1.0, 8.0)
_MOST_LAPSE = 0.6
_BAND = (0.05, 0.95)


@dataclass(frozen=True)
class Found:
    """A size with its interval of 90 %; None where the curve does not reach the share."""

    size: float | None
    low: float | None
    high: float | None


class Curve:
    """The posterior of one cell's curve, given trials at sizes between `least` and `most`."""

    def __init__(self, sizes: Array, found: NDArray[np.bool_], least: float, most: float) -> None:
        margin = np.log(4.0)
        self._middle = np.linspace(np.log(least) - margin, np.log(most) + margin, _MIDDLES)
        self._width = np.geomspace(*_WIDTH, _WIDTHS)
        self._lapse = np.linspace(0.0, _MOST_LAPSE, _LAPSES)
        weight = np.broadcast_to(stats.beta.logpdf(self._lapse, *_LAPSE_PRIOR), (_MIDDLES, _WIDTHS, _LAPSES)).copy()
        levels, index = np.unique(sizes, return_inverse=True)
        for k, size in enumerate(levels):
            p = np.clip(self._share(size), 1e-6, 1.0 - 1e-6)
            hits, all_of = int(found[index == k].sum()), int((index == k).sum())
            weight += hits * np.log(p) + (all_of - hits) * np.log1p(-p)
        weight = np.exp(weight - weight.max())
        self._weight = weight / weight.sum()

    def share(self, size: float) -> tuple[float, float, float]:
        """Mean of P(found) at a size, with its band of 90 %."""
        p = self._share(size).ravel()
        low, high = _quantiles(p, self._weight.ravel(), _BAND)
        return float(p @ self._weight.ravel()), low, high

    def size_at(self, share: float) -> Found:
        """Return the size found in a share of the recordings: the posterior's median and its interval of 90 %."""
        low, middle, high = self.quantiles_at(share, (_BAND[0], 0.5, _BAND[1]))
        return Found(middle, low, high)

    def quantiles_at(self, share: float, levels: tuple[float, ...]) -> tuple[float | None, ...]:
        """Quantiles of the posterior of the size found in a share; None where that share is not reached there."""
        reached = share / (1.0 - self._lapse)
        z = np.where(reached < 1.0, stats.norm.ppf(np.minimum(reached, 1.0 - 1e-12)), np.inf)
        at = self._middle[:, None, None] + self._width[None, :, None] * z
        found = _quantiles(at.ravel(), self._weight.ravel(), levels)
        return tuple(float(np.exp(x)) if np.isfinite(x) and x <= self._middle[-1] else None for x in found)

    def _share(self, size: float) -> Array:
        rise = stats.norm.cdf((np.log(size) - self._middle[:, None]) / self._width)
        out: Array = rise[:, :, None] * (1.0 - self._lapse)
        return out


def wilson(hits: int, of: int) -> tuple[float, float]:
    """Return the interval of 90 % of a share (E. Wilson, JASA 22, 1927)."""
    if of == 0:
        return 0.0, 1.0
    z, p = 1.645, hits / of
    centre, spread = p + z * z / (2 * of), z * np.sqrt(p * (1 - p) / of + z * z / (4 * of * of))
    return float((centre - spread) / (1 + z * z / of)), float((centre + spread) / (1 + z * z / of))


def _quantiles(values: Array, weights: Array, levels: tuple[float, ...]) -> tuple[float, ...]:
    order = np.argsort(values)
    summed = np.cumsum(weights[order])
    return tuple(float(values[order][min(int(np.searchsorted(summed, level)), len(order) - 1)]) for level in levels)
