"""What no motion can be read from: refused in one line with the remedy."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from armtwin.models.errors import RecordingError, nearest, shown
from armtwin.models.recordings.moving import MovingRecording

# An arm moves in fractions of a second: rows that are further apart do not sample it, or their times are no seconds.
_LONGEST_ROW_S = 1.0
# And no log of joints has five thousand rows a second.
_SHORTEST_ROW_S = 2e-4
_LEAST_READINGS = 3
_STILL_RAD = 1e-6


def check_motions(recording: MovingRecording) -> None:
    """Raise `RecordingError` where names, times, commands or readings allow no diagnosis."""
    _names(recording)
    _times(recording)
    moved = np.ptp(recording.q_cmd, axis=0) > 0.0
    if not moved.any():
        raise RecordingError("samples.csv: no command ever changes; a log in which the arm is moved is wanted")
    _refuse_echoes(recording, moved)
    stuck = np.zeros(recording.n_joints, dtype=bool)
    for joint in range(recording.n_joints):
        seen = recording.q_meas[np.isfinite(recording.q_meas[:, joint]), joint]
        if len(seen) < _LEAST_READINGS:
            raise RecordingError(
                f"samples.csv: column 'theta{joint + 1}_meas_rad' is empty; measured angles are wanted"
            )
        stuck[joint] = np.ptp(seen) <= _STILL_RAD
    if stuck[moved].all():
        raise RecordingError(
            "samples.csv: no measured angle ever changes while the commands do: readings that are stuck, or an arm "
            "that is not switched on; log again"
        )


def _refuse_echoes(recording: MovingRecording, moved: NDArray[np.bool_]) -> None:
    """Refuse readings that are the commands again: what is logged is the servo's goal, or nobody moved."""
    apart = np.abs(recording.q_meas - recording.q_cmd)[:, moved]
    if np.nanmax(apart) <= _STILL_RAD:
        raise RecordingError(
            "samples.csv: every measured angle is the command of its row: the goal was logged again, not the position; "
            "log what the encoders read"
        )


def _names(recording: MovingRecording) -> None:
    names = set(recording.motions)
    for key, stated in (("held_out", recording.held_out), ("trajectories", recording.settings)):
        for name in stated:
            if name not in names:
                raise RecordingError(
                    f"recording.json: {key} names trajectory '{shown(name)}', which samples.csv does not have"
                    + nearest(name, names)
                )
    if len(names) != len(recording.motions):
        again = next(name for name in recording.motions if recording.motions.count(name) > 1)
        raise RecordingError(
            f"samples.csv: trajectory '{shown(again)}' begins twice; each is one motion: give the second its own name"
        )
    if names == set(recording.held_out):
        raise RecordingError("recording.json: held_out names every trajectory; leave one to fit")


def _times(recording: MovingRecording) -> None:
    spans = np.diff(recording.time_s)[~recording.first[1:]]
    if not len(spans):
        raise RecordingError("samples.csv: every row is a trajectory of its own; rows of one motion share its name")
    apart = float(np.median(spans))
    if apart > _LONGEST_ROW_S:
        unit, column = ("milli", "time_ms") if apart < 1e3 * _LONGEST_ROW_S else ("micro", "time_us")
        raise RecordingError(
            f"samples.csv: column 'time_s': rows are {apart:g} s apart, in which no motion is seen; are these "
            f'{unit}seconds? name the column {column}. Of poses at rest leave "motion" out of recording.json'
        )
    if apart < _SHORTEST_ROW_S:
        raise RecordingError(
            f"samples.csv: column 'time_s': rows are {apart:g} s apart, more often than any arm is read; are its times "
            "seconds?"
        )
