"""How a joint answers over frequency, at several amplitudes: gain, delay and coherence from command to reading.

Welch's cross-spectra over overlapping windows, which are grouped by how far the command swings in them: a linear servo
answers alike at every amplitude, friction and play weaken small swings, a speed limit large ones.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armtwin.models.recordings.moving import MovingRecording

Array = NDArray[np.float64]

_WINDOW_S = 4.0
_MOST_GROUPS = 3
# A group of fewer windows has no coherence to speak of, and a swing below this is none.
_FEWEST, _LEAST_SWING_RAD = 3, 2e-3
# A frequency counts where the command has this share of its strongest one's power.
_EXCITED = 1e-3
_MOST_HZ = 12.0


@dataclass(frozen=True, eq=False)
class Response:
    """Swings of one size: `swing_rad` (RMS), and over (F,) `frequency_hz` gain, delay in s and coherence, 0 to 1."""

    swing_rad: float
    windows: int
    frequency_hz: Array
    gain: Array
    delay_s: Array
    coherence: Array


def responses(recording: MovingRecording, joint: int, answer: Array) -> list[Response]:
    """Return how `answer` (N,), rad, follows the commands of a joint (from 0), the smallest swings first."""
    step = float(np.median(np.diff(recording.time_s)[~recording.first[1:]]))
    n = max(16, round(_WINDOW_S / step))
    windows = _windows(recording, joint, answer, step, n)
    if len(windows) < _FEWEST:
        return []
    swing = np.array([np.std(sent) for sent, _ in windows])
    order = np.argsort(swing)
    groups = np.array_split(order, min(_MOST_GROUPS, len(windows) // _FEWEST))
    return [one for group in groups if (one := _response([windows[k] for k in group], swing[group], step)) is not None]


def _windows(recording: MovingRecording, joint: int, answer: Array, step: float, n: int) -> list[tuple[Array, Array]]:
    """Return commands and answers on an even grid, half overlapping, in which the joint is swung about."""
    out = []
    given = recording.time_s if recording.commanded_s is None else np.maximum.accumulate(recording.commanded_s)
    for motion in recording.motions:
        rows = recording.rows_of(motion)
        rows = rows[np.isfinite(answer[rows])]
        if len(rows) < 2:
            continue
        grid = np.arange(recording.time_s[rows[0]], recording.time_s[rows[-1]], step)
        held = np.clip(np.searchsorted(given, grid + 1e-3 * step, side="right") - 1, 0, None)
        sent, seen = recording.q_cmd[held, joint], np.interp(grid, recording.time_s[rows], answer[rows])
        for begin in range(0, len(grid) - n + 1, n // 2):
            part = slice(begin, begin + n)
            if np.std(sent[part]) > _LEAST_SWING_RAD:
                out.append((sent[part], seen[part]))
    return out


def _response(windows: list[tuple[Array, Array]], swing: Array, step: float) -> Response | None:
    n = len(windows[0][0])
    taper = np.hanning(n)
    X = np.array([np.fft.rfft(taper * _level(sent)) for sent, _ in windows])
    Y = np.array([np.fft.rfft(taper * _level(seen)) for _, seen in windows])
    f = np.fft.rfftfreq(n, step)
    power, answered = (np.abs(X) ** 2).mean(axis=0), (np.abs(Y) ** 2).mean(axis=0)
    cross = (np.conj(X) * Y).mean(axis=0)
    counts = (f > 0.5 / _WINDOW_S) & (f < min(_MOST_HZ, 0.4 / step)) & (power > _EXCITED * power[1:].max())
    if not counts.any():
        return None
    H = cross[counts] / power[counts]
    coherence = np.abs(cross[counts]) ** 2 / np.maximum(power[counts] * answered[counts], 1e-30)
    delay = -np.unwrap(np.angle(H)) / (2.0 * np.pi * f[counts])
    size = float(np.sqrt(np.mean(swing**2)))
    return Response(size, len(windows), f[counts], np.abs(H), delay, np.minimum(coherence, 1.0))


def _level(values: Array) -> Array:
    """Return values without their line."""
    t = np.linspace(-1.0, 1.0, len(values))
    return np.asarray(values - values.mean() - t * (t @ values) / (t @ t))
