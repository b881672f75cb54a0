"""What happens in single rows: readings that are gross errors, and commands that a servo missed."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from armtwin.calib.motion.joint_model import JointModel
from armtwin.calib.motion.series import Series, spread
from armtwin.models.motion.loop import INDEX, received

Array = NDArray[np.float64]
Rows = NDArray[np.intp]

# A gross error stands out of the noise by so many deviations, and out of its neighbours by so many times theirs.
_GROSS, _ALONE = 8.0, 4.0
# A missed command explains its blip by so much deviance, and the blip's size to within this share.
_PLAIN, _SIZE = 30.0, 0.35
_FEWEST = 3
# A blip has died away after so many time constants.
_LASTS = 5.0


def gross_rows(series: Series, model: JointModel) -> Rows:
    """Return the rows whose reading is a gross error: alone in time, and far beyond the noise."""
    e = np.where(series.used, model.fit.e, 0.0)
    before, after = np.roll(e, 1), np.roll(e, -1)
    own = np.abs(e - 0.5 * (before + after))
    around = np.maximum(np.abs(before), np.abs(after))
    usual = max(model.noise_rad, spread(e[series.used]))
    # What a row of bad timing would make of a fast move is no gross error.
    moved = np.abs(np.diff(model.fit.e + series.measured, prepend=series.measured[0]))
    quiet = np.abs(e) > np.maximum(moved, np.roll(moved, -1))
    far = quiet & (own > _GROSS * usual) & (np.abs(e) > _ALONE * np.maximum(around, model.noise_rad)) & series.used
    rows = np.flatnonzero(far)
    return rows if len(rows) >= _FEWEST else rows[:0]


def missed_rows(series: Series, model: JointModel) -> Rows:
    """Return the rows whose command the servo missed: it stayed with the one before until the next.

    A missed command leaves a blip in the remainder: the loop's answer to a pulse as long as the row and as high as the
    step that was missed.
    """
    p = model.fit.p
    # Where a threshold is a hair off, a step of it comes a row too late, which looks the same.
    least = max(2.0 * model.noise_rad, 2.5 * p[INDEX["dead_band_rad"]], 2.5 * p[INDEX["step_rad"]])
    delay, tau = p[INDEX["delay_s"]], p[INDEX["time_constant_s"]]
    heard = received(series.sent, p)
    steps = np.diff(heard, prepend=heard[0])
    gains: list[tuple[float, int]] = []
    for row in np.flatnonzero(np.abs(steps) > least):
        if row + 2 >= len(series) or series.first[row]:
            continue
        begin, end = series.time_s[row] + delay, series.time_s[row + 1] + delay
        last = int(np.searchsorted(series.time_s, end + _LASTS * tau))
        seen = np.arange(row + 1, min(last, len(series)))
        seen = seen[series.used[seen] & ~np.logical_or.accumulate(series.first[seen])]
        t = series.time_s[seen]
        pulse = _answer(t - begin, tau) - _answer(t - end, tau)
        blip = steps[row] * pulse  # predicted less measured, where the step was missed
        energy = float(blip @ blip)
        if energy < _PLAIN * model.noise_rad**2:
            continue
        size = float(blip @ model.fit.e[seen]) / energy
        gain = (2.0 * size - 1.0) * energy / model.noise_rad**2
        if abs(size - 1.0) < _SIZE and gain > _PLAIN:
            gains.append((gain, int(row)))
    rows = np.array(sorted(row for _, row in gains), dtype=np.intp)
    return rows if len(rows) >= _FEWEST else rows[:0]


def without_commands(series: Series, rows: Rows) -> Array:
    """(N,) commands of which those of some rows were missed."""
    sent = series.sent.copy()
    for row in np.sort(rows):
        if row > 0:
            sent[row] = sent[row - 1]
    return sent


def _answer(t: Array, tau: float) -> Array:
    """Return a first-order loop's answer to a step at time 0."""
    return np.where(t > 0.0, 1.0 - np.exp(-np.maximum(t, 0.0) / tau), 0.0)
