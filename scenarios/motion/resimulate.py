"""The extended twin moved by MuJoCo through the held-out motions, by the effects' injectors alone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armtwin.calib.motion.diagnosis import MotionDiagnosis
from armtwin.models.errors import InputError
from armtwin.models.motion_world import Motion
from armtwin.scenarios.motion.twin import moving_twin_of
from armtwin.sim.motion.twin import simulate_twin_motion

Array = NDArray[np.float64]

# What only single rows had is no property of the arm.
_OF_ROWS = ("outliers", "missed_command", "sampling")
# Longer motions are not re-simulated whole: MuJoCo needs about a tenth of the time that the arm took.
_MOST_ROWS = 8000
_BEFORE = 3


@dataclass(frozen=True, eq=False)
class Resimulated:
    """How far the re-simulated twin is from the held-out motions: RMS (n,) rad a joint, and what it could not hold."""

    rms_rad: Array
    left_out: tuple[str, ...]


def resimulated(found: MotionDiagnosis) -> Resimulated | None:
    """Move the twin through the held-out motions; None where none is whole, or MuJoCo cannot build the arm."""
    recording = found.recording
    whole = [name for name in found.problem.held_motions if found.problem.held[recording.rows_of(name)].all()]
    if not whole or found.loud:
        return None
    motions: list[Motion] = []
    starts: list[Array | None] = []
    measured: list[Array] = []
    for name in whole:
        rows = recording.rows_of(name)[:_MOST_ROWS]
        if not np.isfinite(recording.q_meas[rows[0]]).all():
            continue
        before = np.arange(max(0, rows[0] - _BEFORE), rows[0])
        if len(before):  # the command that is in force when the motion begins was given in the one before
            motions.append(Motion(f"before {name}", recording.time_s[before], recording.q_cmd[before]))
            starts.append(None)
            measured.append(np.full((len(before), recording.n_joints), np.nan))
        motions.append(Motion(name, recording.time_s[rows], recording.q_cmd[rows]))
        starts.append(recording.q_meas[rows[0]])
        measured.append(recording.q_meas[rows])
    if not motions:
        return None
    twin = moving_twin_of(found)
    causes = [cause for cause in twin.causes if cause[0] not in _OF_ROWS]
    made = [name for name, *_ in causes]
    try:
        readings = simulate_twin_motion(causes, twin.arm, motions, starts, twin.zeros_rad)
    except (InputError, ValueError):  # ValueError: MuJoCo's, of what nothing can have
        return None
    gap = readings - np.concatenate(measured)
    # An effect at two joints of which one cannot be made counts as left out as well.
    left = [c.effect for c in found.causes if made.count(c.effect) < sum(o.effect == c.effect for o in found.causes)]
    return Resimulated(np.sqrt(np.nanmean(gap**2, axis=0)), tuple(dict.fromkeys(left)))
