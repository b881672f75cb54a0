"""Commands that a servo missed for several rows: the arm goes on to where it was sent last, and then catches up."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from armtwin.calib.motion.joint_model import JointModel
from armtwin.calib.motion.series import Series, spread
from armtwin.models.motion.loop import INDEX

Array = NDArray[np.float64]
Rows = NDArray[np.intp]

# A run begins where the remainder leaves the noise by so much, and has so many rows.
_LEAVES, _LEAST_ROWS = 8.0, 3
# Rows of the remainder that are this near to one another belong to one run.
_GAP_ROWS = 3
# A held command has to take away so much of a run's squares; then the run was that.
_TAKEN = 0.8
_LASTS = 5.0
_MOST_RUNS = 60
# One row or two are found otherwise.
_SHORTEST = 3


def missed_runs(series: Series, model: JointModel) -> Rows:
    """Return the rows in which a servo did not hear its commands, in runs."""
    sent = series.sent.copy()
    found: list[int] = []
    for begin, end in _loud_runs(series, model)[:_MOST_RUNS]:
        held = _held(series, model, sent, begin, end)
        if held is not None:
            first, last = held
            # What says the same as the command that is held makes no difference, missed or heard.
            found += [row for row in range(first, last) if abs(sent[row] - sent[first - 1]) > model.noise_rad]
            sent[first:last] = sent[first - 1]
    return np.array(sorted(set(found)), dtype=np.intp)


def _loud_runs(series: Series, model: JointModel) -> list[tuple[int, int]]:
    e = np.where(series.used, np.abs(model.fit.e), 0.0)
    loud = np.flatnonzero(e > _LEAVES * max(model.noise_rad, spread(model.fit.e[series.used])))
    if not len(loud):
        return []
    pieces = np.split(loud, np.flatnonzero(np.diff(loud) > _GAP_ROWS) + 1)
    return [(int(p[0]), int(p[-1]) + 1) for p in pieces if len(p) >= _LEAST_ROWS]


def _held(series: Series, model: JointModel, sent: Array, begin: int, end: int) -> tuple[int, int] | None:
    """Return from which row to which (exclusive) the command before was held, or None where that explains little."""
    number = np.cumsum(series.first)
    motion = number == number[begin]
    memory_s = model.fit.p[INDEX["delay_s"]] + _LASTS * model.fit.p[INDEX["time_constant_s"]]
    back = int(np.ceil(memory_s / series.row_s)) + 2
    window = np.zeros(len(series), dtype=bool)
    window[max(0, begin - 2) : min(len(series), end + back)] = True
    window &= motion & series.used

    def cost(first: int, last: int) -> float:
        held = sent.copy()
        held[first:last] = held[first - 1]
        e = replace(series, sent=held, wanted=motion).remainder(model.fit.p)
        return float((e[window] ** 2).sum())

    before = cost(begin, begin)
    firsts = [row for row in range(max(1, begin - back), begin + 1) if motion[row]]
    lasts = list(range(max(begin, end - back), end + 1))
    if not firsts or lasts[-1] <= firsts[0]:
        return None
    tried = [(cost(first, last), first, last) for first in firsts for last in lasts if last - first >= _SHORTEST]
    least = min(tried, default=(np.inf, 0, 0))[0]
    if least > (1.0 - _TAKEN) * before:
        return None
    # Where the command stands still it does not matter which of its rows was missed: the fewest are told.
    noise = len(np.flatnonzero(window)) * model.noise_rad**2
    alike = [(last - first, first, last) for left, first, last in tried if left <= least + noise]
    _, first, last = min(alike)
    return first, last
