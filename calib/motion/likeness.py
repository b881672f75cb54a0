"""How alike commands and readings are: their speeds against each other, over the delay between them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armtwin.models.recordings.moving import MovingRecording

Array = NDArray[np.float64]

# Delays between these are looked at, s: an arm that answers before it was told, and one that takes its time.
EARLIEST_S, LATEST_S = -1.0, 1.5
# Both are seen on a grid of at most so many points, and blurred by this: a step of a command is an instant, an arm's
# takes a while.
_MOST_POINTS = 60_000
_BLUR_S = 0.08
_LEAST_MOVE_RAD = 1e-3


@dataclass(frozen=True, eq=False)
class Likeness:
    """Each joint's commands against each joint's readings.

    Attributes:
        lag_s: (L,) delays.
        correlation: (n, n, L) of commands (first) and readings (second), -1 to 1.
        moves, turns: (n,) whether its commands, its readings change.

    """

    lag_s: Array
    correlation: Array
    moves: NDArray[np.bool_]
    turns: NDArray[np.bool_]

    def best(self, one: int, other: int) -> tuple[float, float]:
        """Return the correlation that is furthest from zero, and its delay, s."""
        at = int(np.argmax(np.abs(self.correlation[one, other])))
        return float(self.correlation[one, other, at]), float(self.lag_s[at])


def likeness(recording: MovingRecording, rows: NDArray[np.intp] | None = None) -> Likeness:
    """Return how alike the commands and readings of a recording, or of some of its rows in their order, are."""
    chosen = np.arange(len(recording)) if rows is None else rows
    time = recording.time_s[chosen]
    usual = float(np.median(np.diff(time))) if len(time) > 1 else 1.0
    step = max(min(usual, 0.02), float(time[-1] - time[0]) / _MOST_POINTS, 1e-4)
    grid = np.arange(time[0], time[-1] + step / 2, step)
    given = time if recording.commanded_s is None else np.maximum.accumulate(recording.commanded_s[chosen])
    blur = np.hanning(max(3, round(2 * _BLUR_S / step) | 1) + 2)[1:-1]
    held = np.clip(np.searchsorted(given, grid + 1e-3 * step, side="right") - 1, 0, None)
    sent = recording.q_cmd[chosen][held]
    n = recording.n_joints
    a, b = np.zeros((n, len(grid) - 1)), np.zeros((n, len(grid) - 1))
    moves, turns = np.zeros(n, dtype=bool), np.zeros(n, dtype=bool)
    for joint in range(n):
        seen = recording.q_meas[chosen, joint]
        known = np.isfinite(seen)
        moves[joint] = np.ptp(sent[:, joint]) > _LEAST_MOVE_RAD
        turns[joint] = known.sum() > 2 and np.ptp(seen[known]) > _LEAST_MOVE_RAD
        if moves[joint]:
            a[joint] = _unit(np.convolve(np.diff(sent[:, joint]), blur, "same"))
        if turns[joint]:
            b[joint] = _unit(np.convolve(np.diff(np.interp(grid, time[known], seen[known])), blur, "same"))
    first, last = round(EARLIEST_S / step), round(LATEST_S / step)
    lags = np.arange(first, last + 1)
    length = 1 << (len(grid) + max(-first, last)).bit_length()
    A, B = np.conj(np.fft.rfft(a, length)), np.fft.rfft(b, length)
    correlation = np.stack([[np.fft.irfft(A[i] * B[j], length)[lags] for j in range(n)] for i in range(n)])
    return Likeness(np.asarray(step * lags, dtype=float), correlation, moves, turns)


def _unit(speed: Array) -> Array:
    size = float(np.sqrt(speed @ speed))
    return speed / size if size > 0.0 else speed
