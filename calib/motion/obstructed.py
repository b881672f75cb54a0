"""Stretches in which something stops the arm: it stays far shorter of its command than elsewhere, and waits."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from armtwin.calib.motion.series import Series, rms, spread

Array = NDArray[np.float64]
Rows = NDArray[np.intp]

# The remainder is beyond so many deviations of all rows, and of an angle that nobody overlooks, for so long.
_DEVIATIONS, _PLAIN_RAD, _LASTS_S = 4.0, 0.015, 0.4
# In so many of its rows it waits: a swing that turns back waits at its ends alone.
_WAITS = 0.7
# Around a stretch the rows in which the arm gets into it and out of it are left out too.
_AROUND = 2.0
# More of a log than this is not in anyone's way: the model is wrong.
_MOST = 0.15


def obstructed(series: Series, e: Array) -> Rows:
    """Return the rows, of those that count, in which the arm is stopped short of its command, by a remainder `e`."""
    used = series.used
    usual = max(spread(e[used]), series.grain_rad)
    # Predicted less measured has the sign in which the arm was sent and did not go.
    short = e * np.sign(series.sent - series.measured) > 0.0
    loud = used & short & (np.abs(e) > max(_DEVIATIONS * usual, _PLAIN_RAD))
    slow = np.abs(np.gradient(series.measured, series.time_s)) < _moves_at(series)
    stuck = np.flatnonzero(loud & slow)
    if not len(stuck):
        return stuck
    apart = np.flatnonzero((np.diff(series.time_s[stuck]) > _LASTS_S) | (np.diff(np.cumsum(series.first)[stuck]) > 0))
    motion = np.cumsum(series.first)
    out = np.zeros(len(series), dtype=bool)
    for piece in np.split(stuck, apart + 1):
        begin, end = int(piece[0]), int(piece[-1])
        if series.time_s[end] - series.time_s[begin] < _LASTS_S or len(piece) < _WAITS * (end - begin):
            continue
        quiet = np.abs(e) < _AROUND * usual
        while begin > 0 and motion[begin - 1] == motion[end] and not quiet[begin - 1]:
            begin -= 1
        last = end
        while last + 1 < len(series) and motion[last + 1] == motion[end] and not quiet[last + 1]:
            last += 1
        out[begin : last + 1] = True
    rows = np.flatnonzero(out & used)
    return rows if len(rows) < _MOST * used.sum() else rows[:0]


def _moves_at(series: Series) -> float:
    """Return a speed, rad/s, below which the joint, compared with its usual one, waits."""
    speed = np.gradient(series.measured, series.time_s)
    return 0.5 * rms(speed[series.used])
