"""A fair part of a long recording: runs of poses spread evenly over it, each led up to by poses that do not count.

What remembers (play, friction, a servo under way) depends on the poses before, so whole runs are taken, and of each the
first poses only bring the arm to where it was.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from armtwin.models.recordings.recording import Recording

Array = NDArray[np.float64]

# Poses of a run that count, and that lead up to it.
_RUN = 40
_LEAD = 8
# No more poses than these are ever looked at: time and memory grow with them, and what is found hardly does.
MOST_POSES = 8000
# Runs begin at uneven places of their shares, so that no plan of even period is always met at the same phase.
_GOLDEN = 0.6180339887498949


@dataclass(frozen=True, eq=False)
class Part:
    """Rows (K,) of a recording, ascending, and which of them (K,) count."""

    rows: NDArray[np.int64]
    counted: NDArray[np.bool_]

    def here(self, row: float, n: int) -> float:
        """Return where a row of the whole, n of `never`, is in the part: the first that is not before it."""
        return float(len(self.rows)) if row >= n else float(np.searchsorted(self.rows, row))

    def there(self, row: float, n: int) -> float:
        """Return the row of the whole, n of `never`, that a row of the part is."""
        return float(n) if row >= len(self.rows) else float(self.rows[int(row)])


def fair_part(n: int, most: int) -> Part:
    """Return about `most` of n rows that count, all of them where there are no more."""
    if n <= most:
        return Part(np.arange(n), np.ones(n, dtype=bool))
    runs = max(most // _RUN, 1)
    share = n / runs
    counted = np.zeros(n, dtype=bool)
    taken = np.zeros(n, dtype=bool)
    for k in range(runs):
        start = int(k * share + (k * _GOLDEN % 1.0) * max(share - _RUN, 0.0))
        counted[start : start + _RUN] = True
        taken[max(start - _LEAD, 0) : start + _RUN] = True
    rows = np.flatnonzero(taken)
    return Part(rows, counted[rows])


def part_of(recording: Recording, part: Part) -> Recording:
    """Return the rows of a part as a recording; of those that do not count nothing was measured."""
    rows, unseen = part.rows, ~part.counted

    def seen(values: Array) -> Array:
        out = values[rows].copy()
        out[unseen] = np.nan
        return out

    def some(values: Array | None) -> Array | None:
        return None if values is None else values[rows]

    return replace(
        recording,
        sample=recording.sample[rows],
        time_s=recording.time_s[rows],
        trajectory=recording.trajectory[rows],
        q_cmd=recording.q_cmd[rows],
        markers_px={name: seen(pixels) for name, pixels in recording.markers_px.items()},
        q_meas=None if recording.q_meas is None else seen(recording.q_meas),
        commanded_s=some(recording.commanded_s),
        payload_kg=some(recording.payload_kg),
        temperature_c=some(recording.temperature_c),
        held_out=tuple(name for name in recording.held_out if name in set(recording.trajectory[rows])),
    )


def shortened(recording: Recording) -> Recording:
    """Return a recording as it is, or of a very long one a fair part; of a part again the same part."""
    if len(recording) <= MOST_POSES * (_RUN + _LEAD) // _RUN:
        return recording
    part = fair_part(len(recording), MOST_POSES)
    return part_of(recording, part)
