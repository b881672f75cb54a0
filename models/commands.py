"""A series of commands, and the moments at which what they made of the arm was seen.

A settled recording is seen once a command, after the arm had its time; a moving one is seen again and again while
commands come. Both are one thing: commands with the times at which they were given, and the times of sight.

    settled   given 0   seen 0 | given 1   seen 1 | given 2 ...     row i shows command i
    moving    seen 0, given 0 | seen 1, given 1 | seen 2 ...        row i shows the command of row i - 1

What remembers (play, a servo's lag) steps through the commands in their order and is then sampled at the rows.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class CommandSeries:
    """M commands in the order they were given, seen in N rows.

    Attributes:
        q: (M, n) commanded joint angles, rad.
        given_s: (M,) when each was given, s, never running backwards; in rows where time was not recorded.
        seen_s: (N,) when each row was seen, on the same clock.
        in_force: (N,) number of the command that was in force when a row was seen; the first one where none was yet.
        timed: whether the times were recorded; otherwise one row counts as one second.

    """

    q: Array
    given_s: Array
    seen_s: Array
    in_force: NDArray[np.intp]
    timed: bool

    def __len__(self) -> int:
        return len(self.q)

    @cached_property
    def waits_s(self) -> Array:
        """(N,) time from the command in force to the sight of each row."""
        return self.seen_s - self.given_s[self.in_force]

    @cached_property
    def spans_s(self) -> Array:
        """(M,) time for which each command was in force: to the next one, and for the last to the last sight."""
        ends = np.append(self.given_s[1:], max(self.seen_s[-1], self.given_s[-1]))
        out: Array = ends - self.given_s
        return out

    def sampled(self, of_commands: Array) -> Array:
        """(N, ...) rows of what is known of each command (M, ...), as it stood when each row was seen."""
        return of_commands[self.in_force]

    def at(self, time_s: Array, delay_s: float = 0.0) -> Array:
        """(K, n) commands in force at times (K,) for an arm that hears each `delay_s` after it was given.

        A command that is given at that very moment does not act yet; before the first one, that one is returned.
        """
        number = np.searchsorted(self.given_s, np.asarray(time_s) - delay_s, side="left") - 1
        out: Array = self.q[np.maximum(number, 0)]
        return out


def settled_commands(q: Array, time_s: Array | None, commanded_s: Array | None = None) -> CommandSeries:
    """Return the series of a settled recording: (N, n) commands, each seen once, at (N,) `time_s`.

    Where `commanded_s` (N,) is not known (None, or NaN in a row) the command was given when the row before was seen,
    the first one a usual wait before it was. Without times rows stand for seconds.
    """
    rows = np.arange(len(q), dtype=float)
    seen = rows if time_s is None else np.asarray(time_s, dtype=float)
    waits = np.diff(seen)
    first = seen[0] - (float(np.median(waits)) if len(waits) else 1.0)
    given = np.append(first, seen[:-1])
    if time_s is not None and commanded_s is not None:
        given = np.where(np.isfinite(commanded_s), commanded_s, given)
    return CommandSeries(q, given, seen, np.arange(len(q)), timed=time_s is not None)


def moving_commands(q: Array, time_s: Array, commanded_s: Array | None = None) -> CommandSeries:
    """Return the series of a moving recording: (N, n) commands, each in force from its row's `time_s` (N,) on.

    A row is read before its command acts, so it shows the command of the row before. `commanded_s` (N,) says when a
    command was given where that was another moment.
    """
    seen = np.asarray(time_s, dtype=float)
    given = seen if commanded_s is None else np.where(np.isfinite(commanded_s), commanded_s, seen)
    before = np.searchsorted(given, seen, side="left") - 1
    return CommandSeries(q, given, seen, np.maximum(before, 0), timed=True)
