"""Commands and readings on two clocks: one that runs faster, or an arm that seems to answer before it is told."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from armtwin.calib.motion.fit import ZERO, fit, robust_cost, scale_of, with_values
from armtwin.calib.motion.likeness import likeness
from armtwin.calib.motion.problem import angles_of
from armtwin.calib.motion.series import Series, busiest
from armtwin.models.catalogue.motion_effect import Slot
from armtwin.models.motion.loop import INDEX, neutral
from armtwin.models.recordings.moving import MovingRecording

Array = NDArray[np.float64]

# Delays are asked of stretches of this length; of fewer nothing is said of a clock's rate.
_STRETCH_S, _FEWEST = 6.0, 6
# Speeds have to be so much alike in a stretch for its delay to count.
_ALIKE = 0.6
# A clock is told from delays that differ from motion to motion by a line that leaves this share, over so much, s.
_LINE_LEAVES, _LEAST_DRIFT_S = 0.1, 0.1
# And from a bus that falls behind at a moment, which a step explains.
_BETTER_THAN_A_STEP = 0.5
# Commands are moved back by this, so that a fit may find any delay down to it negative, s.
_AHEAD_S = 0.4
_ROWS, _JOINTS = 1500, 3
# The arm answers early where that leaves so much less than answering at once, by more than this and a share of a row.
_PLAINLY, _LEAST_EARLY_S, _OF_A_ROW = 1.3, 0.012, 0.6
_SIGNED = Slot("delay_s", "delay_s", (0.0, 2.0), (0.0,), 0.005)
_SLOW = Slot("time_constant_s", "time_constant_s", (0.005, 0.6), (0.05,), 0.005)


@dataclass(frozen=True)
class ClockRate:
    """The delay grows by `drift` for each second of the readings' clock since `begin_s`."""

    drift: float
    begin_s: float
    span_s: float

    @property
    def said(self) -> str:
        """What it means, in a sentence."""
        way = "slow" if self.drift > 0.0 else "fast"
        return (
            f"the commands' clock runs {100.0 * abs(self.drift):.3g} % {way} against the readings': the delay changes "
            f"by {1e3 * self.drift * self.span_s:+.0f} ms over the log"
        )

    def put(self, recording: MovingRecording) -> MovingRecording:
        """Return the recording with the commands on the clock of the readings."""
        given = recording.time_s if recording.commanded_s is None else recording.commanded_s
        return replace(recording, commanded_s=given + self.drift * (given - self.begin_s))


def clock_rate(recording: MovingRecording) -> ClockRate | None:
    """Return how the commands' clock differs in its rate from the readings', or None where it plainly does not."""
    middles, delays = _delays(recording)
    if len(middles) < _FEWEST:
        return None
    line = np.polyfit(middles, delays, 1)
    left = float(((delays - np.polyval(line, middles)) ** 2).sum())
    total = float(((delays - delays.mean()) ** 2).sum())
    step = min(
        float(((delays[:k] - delays[:k].mean()) ** 2).sum() + ((delays[k:] - delays[k:].mean()) ** 2).sum())
        for k in range(1, len(delays))
    )
    span = float(recording.time_s[-1] - recording.time_s[0])
    plain = left < _LINE_LEAVES * total and left < _BETTER_THAN_A_STEP * step
    if not plain or abs(line[0]) * span < _LEAST_DRIFT_S:
        return None
    return ClockRate(float(line[0]), float(recording.time_s[0]), span)


def _delays(recording: MovingRecording) -> tuple[Array, Array]:
    """(B,) middles of stretches, s, and the delays at which speeds are most alike there, s, all joints together."""
    middles, delays = [], []
    for motion in recording.motions:
        rows = recording.rows_of(motion)
        time = recording.time_s[rows]
        pieces = max(1, round((time[-1] - time[0]) / _STRETCH_S))
        for part in np.array_split(rows, pieces):
            if len(part) < 30:
                continue
            alike = likeness(recording, part)
            own = [alike.correlation[j, j] for j in np.flatnonzero(alike.moves & alike.turns)]
            if not own:
                continue
            mean = np.mean(own, axis=0)
            at = int(np.argmax(mean))
            if mean[at] > _ALIKE and 0 < at < len(mean) - 1:
                before, here, after = mean[at - 1 : at + 2]
                bend = before - 2.0 * here + after
                middles.append(float(recording.time_s[part].mean()))
                delays.append(
                    float(alike.lag_s[at] + 0.5 * (before - after) / bend * (alike.lag_s[1] - alike.lag_s[0]))
                )
    return np.array(middles), np.array(delays)


def answers_early(recording: MovingRecording) -> float:
    """Return by how much the arm answers before it is told, s; 0 where it does not."""
    travel = np.abs(np.diff(recording.q_cmd, axis=0)).sum(axis=0)
    found = []
    for joint in np.argsort(-travel)[:_JOINTS].tolist():
        seen = np.isfinite(recording.q_meas[:, joint])
        if travel[joint] > 0.1 and seen.sum() > 60 and np.ptp(recording.q_meas[seen, joint]) > 0.01:
            found.append(_signed_delay(recording, joint))
    early = [-delay_s for delay_s in found if delay_s is not None]
    if not early or len(early) < 2 * len(found) / 3:
        return 0.0
    return float(np.median(early))


def _signed_delay(recording: MovingRecording, joint: int) -> float | None:
    """Return a joint's delay where it is plainly negative, s, or None."""
    series = busiest(_series(recording, joint), _ROWS)
    if not series.turns_back:  # of a ramp a delay is one with the zero
        return None
    nominal = neutral()
    scale = max(scale_of(series, series.remainder(nominal), 1e-4) / 4.0, 1e-4)
    best: dict[bool, tuple[float, float]] = {}
    for early in (False, True):
        signed = replace(_SIGNED, bounds=(0.0, _AHEAD_S) if early else (_AHEAD_S, _AHEAD_S + 0.5))
        for delay in (0.1, 0.25, 0.38) if early else (_AHEAD_S, _AHEAD_S + 0.05, _AHEAD_S + 0.15):
            start = with_values(nominal, [signed, _SLOW], [delay, 0.05])
            one = fit(series, start, (ZERO, _SLOW, signed), scale)
            cost = robust_cost(one.e[series.used], scale)
            if early not in best or cost < best[early][0]:
                best[early] = (cost, float(one.p[INDEX["delay_s"]]) - _AHEAD_S)
    delay_s = best[True][1]
    least = max(_LEAST_EARLY_S, _OF_A_ROW * series.row_s)
    return delay_s if delay_s < -least and best[True][0] * _PLAINLY < best[False][0] else None


def _series(recording: MovingRecording, joint: int) -> Series:
    given = recording.time_s if recording.commanded_s is None else recording.commanded_s
    angles = angles_of(recording, 0.0)[:, joint]
    return Series(
        time_s=recording.time_s,
        given_s=np.maximum.accumulate(given - _AHEAD_S),
        sent=np.ascontiguousarray(recording.q_cmd[:, joint]),
        load_nm=np.zeros(len(recording)),
        measured=np.ascontiguousarray(angles),
        first=recording.first,
        wanted=np.ones(len(recording), dtype=bool),
        used=np.isfinite(recording.q_meas[:, joint]),
        grain_rad=0.0,
    )
