"""One joint's part of a moving recording, laid out for the loop, and how its remainder is weighed.

Rows of a log are not independent readings: what the model leaves has a memory of many rows. So the remainder is
whitened by an autoregression fitted to itself before anything is tested, and intervals come from whole blocks
(`uncertainty.py`).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from armtwin.models.motion.loop import follow

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

# A remainder's memory over so many rows is taken out; what is longer is a drift, which the blocks allow for.
_ORDER = 6
# What lies further out, in robust deviations, has no more weight in a test: Gaussian noise does not reach it.
_CAP = 6.0
_MAD_TO_STD = 1.4826
_LEAST_STRETCH, _FORGETS_S = 300, 0.5


# A command that changes by less is the same again.
_NO_STEP_RAD = 1e-6


@dataclass(frozen=True, eq=False)
class Series:
    """One joint over all rows of a recording.

    Attributes:
        time_s, given_s, sent, load_nm, measured: (N,) as `follow` takes them; what is missing of `measured` is
            interpolated.
        first: (N,) where motions begin.
        wanted: (N,) motions that are looked at.
        used: (N,) rows of them that count: measured, not held out, not left out.
        grain_rad: step of the readings, or 0.

    """

    time_s: Array
    given_s: Array
    sent: Array
    load_nm: Array
    measured: Array
    first: Mask
    wanted: Mask
    used: Mask
    grain_rad: float

    def __len__(self) -> int:
        return len(self.time_s)

    @property
    def row_s(self) -> float:
        """Usual time from row to row, s."""
        return float(np.median(np.diff(self.time_s)))

    @property
    def turns_back(self) -> bool:
        """Whether the joint is sent both ways in the rows that count."""
        steps = np.diff(self.sent)[self.used[1:] & ~self.first[1:]]
        return bool((steps > _NO_STEP_RAD).any() and (steps < -_NO_STEP_RAD).any())

    @property
    def floor_rad(self) -> float:
        """The deviation of rounding alone: a step/√12."""
        return float(self.grain_rad / np.sqrt(12.0))

    def gain(self, before: Array, after: Array) -> float:
        """Return the deviance by which remainder `after` (N,) explains the rows that count better than `before`."""
        return deviance_gain(before[self.used], after[self.used], self.floor_rad)

    def predicted(self, p: Array) -> Array:
        """(N,) angles of a loop with values `p`, rad."""
        return follow(self.time_s, self.given_s, self.sent, self.load_nm, self.measured, self.first, self.wanted, p)

    def remainder(self, p: Array) -> Array:
        """(N,) predicted less measured, rad; 0 in rows that do not count."""
        return np.where(self.used, self.predicted(p) - self.measured, 0.0)


def busiest(series: Series, most_rows: int) -> Series:
    """Return the series with the busiest stretch of every motion alone, about `most_rows` in all.

    A stretch begins at the angle measured there; what the loop remembers of before is gone after `_FORGETS_S`.
    """
    total = int(series.used.sum())
    if total <= most_rows:
        return series
    wanted, used, first = np.zeros_like(series.wanted), series.used.copy(), series.first.copy()
    begins = np.flatnonzero(series.first)
    for begin, end in zip(begins, np.append(begins[1:], len(series)), strict=True):
        rows = int(series.used[begin:end].sum())
        length = max(_LEAST_STRETCH, round(most_rows * rows / total))
        if rows == 0:
            continue
        if end - begin > length:
            busy = np.cumsum(np.abs(np.diff(series.sent[begin:end], prepend=series.sent[begin])))
            at = begin + int(np.argmax(busy[length:] - busy[:-length]))
            end = at + length
        else:
            at = begin
        wanted[at:end] = True
        if at > begin:
            first[at] = True
            used[at : at + int(np.searchsorted(series.time_s[at:end] - series.time_s[at], _FORGETS_S))] = False
    return replace(series, wanted=wanted & series.wanted, used=used & wanted, first=first)


def rms(e: Array) -> float:
    """Return the root mean square of a remainder, 0 where it has no row."""
    return float(np.sqrt(np.mean(e**2))) if len(e) else 0.0


def spread(e: Array) -> float:
    """Return the robust standard deviation of a remainder about zero."""
    return float(_MAD_TO_STD * np.median(np.abs(e)))


def white_noise(e: Array, first: Mask, grain_rad: float = 0.0) -> float:
    """Return the standard deviation of what a remainder has without memory, at least that of the readings' steps.

    Second differences take out all that changes slowly. Rounded readings of an arm at rest do not change at all, so the
    floor is a step's: its deviation, step/√12.
    """
    inner = ~(first[2:] | first[1:-1])
    second = np.diff(e, 2)[inner]
    floor = grain_rad / np.sqrt(12.0)
    if len(second) < 8:
        return max(floor, 1e-9)
    robust = spread(second) / np.sqrt(6.0)
    plain = float(np.sqrt(np.mean(np.clip(second, -_CAP * spread(second), _CAP * spread(second)) ** 2) / 6.0))
    return max(robust, plain, floor, 1e-9)


def whitening(e: Array) -> Array:
    """(k,) filter that takes the memory out of a remainder: 1, then minus the coefficients of its autoregression."""
    capped = np.clip(e, -_CAP * max(spread(e), 1e-12), _CAP * max(spread(e), 1e-12))
    n = len(capped)
    lags = np.array([capped[: n - k] @ capped[k:] for k in range(_ORDER + 1)]) / n
    if lags[0] <= 0.0:
        return np.ones(1)
    R = lags[np.abs(np.subtract.outer(np.arange(_ORDER), np.arange(_ORDER)))] + 1e-6 * lags[0] * np.eye(_ORDER)
    return np.append(1.0, -np.linalg.solve(R, lags[1:]))


def innovations(e: Array, taps: Array) -> Array:
    """(N,) what is new in each row of a remainder, rad."""
    return np.asarray(lfilter(taps, [1.0], e))


def deviance_gain(before: Array, after: Array, floor_rad: float) -> float:
    """Return how much better a model explains the rows: the fall of the sum of squares of its innovations.

    It is in units of their variance. Filter and variance are those of the better model, whose remainder is nearer to
    noise.
    """
    taps = whitening(after)
    new, old = innovations(after, taps), innovations(before, taps)
    scale = max(spread(new), float(floor_rad), 1e-12)
    cap = _CAP * scale
    return float((np.minimum(old**2, cap**2) - np.minimum(new**2, cap**2)).sum() / scale**2)


def worth(e: Array) -> float:
    """Return how many independent readings a remainder's rows are worth (by the integrated autocorrelation)."""
    n = len(e)
    centred = np.clip(e, -_CAP * max(spread(e), 1e-12), _CAP * max(spread(e), 1e-12))
    spectrum = np.abs(np.fft.rfft(centred, 2 * n)) ** 2
    correlation = np.fft.irfft(spectrum)[:n]
    if correlation[0] <= 0.0:
        return float(n)
    correlation /= correlation[0]
    below = np.flatnonzero(correlation < 0.05)
    last = int(below[0]) if len(below) else n
    return float(n / max(1.0, 1.0 + 2.0 * correlation[1:last].sum()))


def memory_rows(e: Array) -> int:
    """Return over how many rows a remainder remembers."""
    return max(1, round(len(e) / max(worth(e), 1.0)))
