"""What a moving recording cannot tell, and what was taken for what: one line each."""

from __future__ import annotations

import numpy as np

from armtwin.calib.motion.diagnosis import MotionDiagnosis

# Moves below this are no moves.
_STILL_RAD = 1e-3


def notes(found: MotionDiagnosis) -> list[str]:
    """Say what this recording cannot tell, and what was taken for what."""
    recording = found.recording
    told = [*_clocks(found), *_ties(found), *_moves(found)]
    if not found.problem.has_load:
        told.append("The arm's masses are not known: what grows with the load cannot be looked for.")
    grains = found.problem.grains_rad
    if grains.any():
        steps = ", ".join(f"{np.degrees(g):.3g}°" for g in sorted(set(np.round(grains[grains > 0], 6))))
        told.append(f"Readings come in steps of {steps}; a step/√12 is the floor of their noise.")
    missing = int(np.isnan(recording.q_meas).any(axis=1).sum())
    if missing:
        told.append(f"{missing} rows lack a measured angle; they are passed over.")
    return told


def _clocks(found: MotionDiagnosis) -> list[str]:
    told = []
    if found.recording.clock == "synthetic":
        told.append(
            "Times were made from row numbers and a nominal rate: a delay in seconds is as true as the rate stated."
        )
    if any(cause.effect == "latency" for cause in found.causes):
        told.append("A late command and a late clock of the readings look the same: the delay is the sum of both.")
    return told


def _ties(found: MotionDiagnosis) -> list[str]:
    if not any(cause.effect == "friction" for cause in found.causes):
        return []
    return [
        "At one P gain and one load a band of friction looks like play behind an encoder on the motor's side; it "
        "is called friction where its size follows the drive or the load, or where the servo's answer rounds."
    ]


def _moves(found: MotionDiagnosis) -> list[str]:
    recording, told = found.recording, []
    joints = range(recording.n_joints)
    unsaid = [j for j in joints if not found.problem.moves(j) and j not in found.loud]
    still = [j for j in unsaid if not np.ptp(recording.q_cmd[found.problem.fitted, j]) > _STILL_RAD]
    if still:
        told.append(f"{_joints(still)} got no commands to move: nothing is said of {_them(still)}.")
    stuck = [j for j in unsaid if j not in still]
    if stuck:
        told.append(
            f"{_joints(stuck)} never moved while commanded to, or {'were' if len(stuck) > 1 else 'was'} hardly ever "
            f"read: a servo without power, or a reading that is stuck; nothing is said of {_them(stuck)}."
        )
    one_way = [j for j in joints if found.problem.moves(j) and not found.problem.series[j].turns_back]
    if one_way:
        told.append(
            f"{_joints(one_way)} never turned back: play, hysteresis and dry friction there are one with the joint's "
            "zero; add the same motion backwards."
        )
    return told


def _joints(numbers: list[int]) -> str:
    return f"Joint{'s' if len(numbers) > 1 else ''} {', '.join(str(j + 1) for j in numbers)}"


def _them(numbers: list[int]) -> str:
    return "them" if len(numbers) > 1 else "it"
