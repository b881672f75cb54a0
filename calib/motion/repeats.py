"""A bus that answers only every so many rows: from a moment on the reading before is repeated, at all joints alike."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from armtwin.models.recordings.moving import MovingRecording

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

# So many rows are held at most.
_MOST_ROWS = 60
# A repeated row may be garbled on its way, now and then.
_GARBLED = 0.03
# What repeats has to be so much likelier than an arm that rests (log-likelihood), and its fresh rows have to change.
_PLAIN, _FRESH = 40.0, 0.3
_LEAST_BLOCKS = 12
# Where readings are held at most every second row is fresh.
_NONE_HELD = 0.6


@dataclass(frozen=True, eq=False)
class Repeats:
    """From row `first` on only every `held_rows`th reading is fresh.

    Attributes:
        first: the row of the first reading that is held.
        held_rows: how long each is.
        from_s: between the last row that was surely fresh and the first repeated one, s; `within_s` apart.
        stale: (N,) rows that repeat an older reading.

    """

    first: int
    held_rows: int
    from_s: float
    within_s: float
    stale: Mask


def repeats(recording: MovingRecording) -> Repeats | None:
    """Find from when on readings are repeated in a rhythm; None where they are not."""
    changed = _changed(recording.q_meas)
    n = len(changed)
    if changed[-max(n // 20, 1) :].mean() > _NONE_HELD:
        return None
    usual = float(changed[: max(n // 8, 1)].mean())
    best: tuple[float, int, int] | None = None
    for held in range(2, min(_MOST_ROWS, n // _LEAST_BLOCKS) + 1):
        for phase in range(held):
            gain, first = _onset(changed, usual, held, phase)
            if best is None or gain > best[0]:
                best = (gain, first, held)
    if best is None:
        return None
    _, first, held = best
    after = np.arange(first, n)
    fresh = (after - first) % held == 0
    rate = float(changed[after[fresh]][1:].mean()) if fresh.sum() > _LEAST_BLOCKS else 0.0
    if rate < _FRESH or _rhythm(changed[after], fresh) < _PLAIN or first < held:
        return None
    stale = np.zeros(n, dtype=bool)
    stale[after[~fresh]] = True
    # Readings of an arm at rest are the same, fresh or not: it begins between a row that was surely fresh and a block
    # that was surely held.
    sure = np.flatnonzero(changed & ((np.arange(n) - first) % held != 0) & (np.arange(n) < first))
    seen = after[fresh & changed[after]]
    begin = recording.time_s[sure[-1] if len(sure) else 0]
    end = recording.time_s[seen[0] if len(seen) else first]
    return Repeats(first, held, float(0.5 * (begin + end)), float(end - begin), stale)


def without_stale(recording: MovingRecording, found: Repeats) -> MovingRecording:
    """Return the recording without the readings that repeat older ones."""
    q = recording.q_meas.copy()
    q[found.stale] = np.nan
    return replace(recording, q_meas=q)


def _changed(q: Array) -> Mask:
    """(N,) whether any joint reads otherwise than in the row before."""
    with np.errstate(invalid="ignore"):
        moved = np.abs(np.diff(q, axis=0)) > 0.0
    return np.append(True, moved.any(axis=1))


def _onset(changed: Mask, usual: float, held: int, phase: int) -> tuple[float, int]:
    """Return by how much a rhythm of a phase is likelier than none to the end of the log, and from which row on."""
    rate = min(max(usual, 0.05), 0.98)
    rows = np.arange(len(changed))
    between = (rows - phase) % held != 0
    score = np.where(changed, np.log(_GARBLED / rate), np.log((1.0 - _GARBLED) / (1.0 - rate))) * between
    ahead = np.cumsum(score[::-1])[::-1]
    begins = rows[~between]
    at = int(np.argmax(ahead[begins]))
    return float(ahead[begins[at]]), int(begins[at])


def _rhythm(changed: Mask, fresh: Mask) -> float:
    """Return by how much changes in `fresh` rows alone are likelier than at one rate in all: rest has no rhythm."""

    def loglikelihood(part: Mask) -> float:
        k, n = float(part.sum()), float(len(part))
        return sum(c * np.log(c / n) for c in (k, n - k) if c > 0.0)

    return loglikelihood(changed[fresh]) + loglikelihood(changed[~fresh]) - loglikelihood(changed)
