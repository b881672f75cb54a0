"""Two clocks, one of the commands and one of the readings: told apart where they do not meet, and brought together."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from armtwin.models.errors import InputError

Array = NDArray[np.float64]

# Of the shorter of the two spans so much has to lie in the other; otherwise they are on two clocks.
_MEET = 0.5
# Clocks are brought together to this, and by the likeness of speeds that is at least this.
_STEP_S = 0.01
_ALIKE = 0.5
# A day at the step above is nine million steps; motions are minutes.
_LONGEST_S = 4 * 3600.0


def on_clock_of(
    seen_s: Array, readings: Array, command_s: Array, commands: Array, file: str
) -> tuple[Array, str | None]:
    """Return when commands (M, n) were given, (M,) s, by the clock of the readings (N, n), and a note where it moved.

    What is left of the offset looks like latency. Raises `InputError` where two clocks cannot be brought together.
    """
    if len(command_s) < 2 or len(seen_s) < 2:
        return command_s, None
    spans = float(np.ptp(command_s)), float(np.ptp(seen_s))
    meet = min(command_s.max(), seen_s.max()) - max(command_s.min(), seen_s.min())
    if meet >= _MEET * min(spans):
        return command_s, None
    apart = float(command_s.min() - seen_s.min())
    shift, alike = _likeness(seen_s, readings, command_s - apart, commands)
    if alike < _ALIKE:
        raise InputError(
            f"{file}: commands and readings are on two clocks, {abs(apart):.6g} s apart, and no shift makes them "
            "alike; log both with one clock"
        )
    offset = apart - shift
    ahead = "ahead of" if offset > 0.0 else "behind"
    note = (
        f"the commands' clock is {abs(offset):.6g} s {ahead} the readings': brought together so that the arm answers "
        "at once; of a delay nothing can be told"
    )
    return command_s - offset, note


def _likeness(seen_s: Array, readings: Array, command_s: Array, commands: Array) -> tuple[float, float]:
    """Return by how much commands have to be shifted to be most alike to the readings, s, and the correlation there."""
    begin, end = min(seen_s[0], command_s[0]), max(seen_s[-1], command_s[-1])
    grid = np.arange(begin, min(end, begin + _LONGEST_S), _STEP_S)
    length = 1 << (2 * len(grid) - 1).bit_length()
    total, weight = np.zeros(length), 0.0
    for sent, seen in zip(commands.T, readings.T, strict=True):
        known = np.isfinite(seen)
        if known.sum() < 2 or not np.ptp(sent) or not np.ptp(seen[known]):
            continue
        a = np.diff(np.interp(grid, command_s, sent))
        b = np.diff(np.interp(grid, seen_s[known], seen[known]))
        # Steps of a command are instants, of an arm they take a while: blurred, both are alike.
        a, b = (np.convolve(one, np.hanning(23)[1:-1], "same") for one in (a, b))
        scale = float(np.sqrt((a @ a) * (b @ b)))
        if scale > 0.0:
            total += np.fft.irfft(np.conj(np.fft.rfft(a, length)) * np.fft.rfft(b, length), length) / scale
            weight += 1.0
    if not weight:
        return 0.0, 0.0
    best = int(np.argmax(total))
    return _STEP_S * (best if best < length // 2 else best - length), float(total[best] / weight)
