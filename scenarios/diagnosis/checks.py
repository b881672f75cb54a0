"""Recordings that cannot be diagnosed, refused in one line; and what a recording that can be cannot tell, in notes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from armtwin.calib.diagnosis.lattice import Lattice, command_lattices
from armtwin.models.errors import RecordingError
from armtwin.models.recordings.recording import Recording

Array = NDArray[np.float64]

# With fewer poses order, angle and direction of approach are one and the same: a joint there and back in four steps.
_LEAST_POSES = 8
# Moves below this are no moves: a command repeated.
_STILL_RAD = 1e-6


def check_recording(recording: Recording) -> None:
    """Raise `RecordingError` where nothing, or nothing but by chance, can be told.

    Too few poses, nothing seen, a reading or a clock that is stuck while the arm moves, no joint that ever turns back.
    A command that never changes is none of these: an arm may well be looked at one joint at a time (`notes_on`).
    """
    arm = recording.arm
    missing = _LEAST_POSES - len(recording)
    if missing > 0:
        raise RecordingError(
            f"samples.csv: too short to decide: {len(recording)} poses, at least {_LEAST_POSES} are wanted; add "
            f"{missing} poses"
        )
    _refuse_stuck_clock(recording)
    _refuse_one_sided(recording)
    moving = np.ptp(recording.q_cmd, axis=0) > _STILL_RAD
    if not recording.markers_px:
        assert recording.q_meas is not None
        measured = [f"theta{joint + 1}_meas_rad" for joint in range(arm.n_joints)]
        _refuse_unseen(recording.q_meas, ", ".join(measured), "no angle was measured")
        for joint, name in enumerate(measured):
            if moving[joint]:
                _refuse_stuck(recording.q_meas[:, joint : joint + 1], name, f"theta{joint + 1}_cmd_rad")
        return
    everything = np.concatenate(list(recording.markers_px.values()), axis=0)
    _refuse_unseen(everything, "all marker columns", "no marker was seen")
    first = int(np.argmax(moving)) if moving.any() else arm.n_joints
    for name, pixels in recording.markers_px.items():
        axis = arm.n_joints if name == "e" else arm.marker_names.index(name)
        if axis > first:  # what lies on or before the first moving axis may well stand still
            _refuse_stuck(pixels, f"{name}_u_px and {name}_v_px", f"theta{first + 1}_cmd_rad")


def notes_on(recording: Recording) -> list[str]:
    """Return what this recording cannot tell whatever is found, one line each."""
    return [*_constant(recording), *_one_sided(recording), *_coarse(recording)]


def _refuse_unseen(values: Array, columns: str, what: str) -> None:
    if not np.isfinite(values).any():
        raise RecordingError(f"samples.csv: {columns} are empty in every row; {what}, so there is nothing to diagnose")


def _refuse_stuck(values: Array, columns: str, command: str) -> None:
    seen = values[np.isfinite(values).all(axis=-1)]
    if len(seen) > 2 and not np.ptp(seen, axis=0).all():
        raise RecordingError(
            f"samples.csv: {columns} never change while {command} does; a stuck reading or a frozen picture: "
            "measure again, or remove the columns"
        )


def _refuse_stuck_clock(recording: Recording) -> None:
    if recording.has_time and len(recording) > 1 and np.ptp(recording.time_s) == 0:
        raise RecordingError(
            f"samples.csv: time_s is {recording.time_s[0]:g} in every row, a clock that stands still; leave the column "
            "empty where time was not recorded"
        )


def _refuse_one_sided(recording: Recording) -> None:
    """Refuse commands of which none ever turns back.

    Each cause then follows the order, the time and the angle alike: play is a joint's zero, friction that builds up a
    servo's nonlinearity, creep a gain. Whatever would be named could be any of them. Where some joint turns back the
    others' errors differ from its own, so `notes_on` only says what cannot be told of them.
    """
    turns = _turns(recording)
    moving = {joint: signs for joint, signs in enumerate(turns, start=1) if len(signs)}
    if moving and all(len(signs) == 1 for signs in moving.values()):
        ways = ", ".join(f"theta{joint}_cmd_rad only {_way(signs)}" for joint, signs in moving.items())
        raise RecordingError(
            f"samples.csv: no joint ever turns back ({ways}), so every pose is approached from one side, and backlash "
            "or hysteresis cannot be told from a joint's zero or gain; add the same poses in reverse order, from line "
            f"{len(recording) + 1} back to line 2"
        )


def _way(signs: Array) -> str:
    return "grows" if signs[0] > 0 else "falls"


def _turns(recording: Recording) -> list[Array]:
    """Signs of each joint's moves, each once: one of a joint that never turns back, none of one that never moves."""
    moves = np.diff(recording.q_cmd, axis=0)
    return [np.unique(np.sign(way[np.abs(way) > _STILL_RAD])) for way in moves.T]


def _constant(recording: Recording) -> list[str]:
    still = np.ptp(recording.q_cmd, axis=0) <= _STILL_RAD
    return [
        f"theta{joint + 1}_cmd_rad never changes: nothing can be told of joint {joint + 1}"
        for joint in np.flatnonzero(still)
    ]


def _one_sided(recording: Recording) -> list[str]:
    """Joints that always turn the same way: play and friction only shift their zero."""
    joints = [str(joint) for joint, signs in enumerate(_turns(recording), start=1) if len(signs) == 1]
    if not joints:
        return []
    return [
        f"joint {', '.join(joints)}: every pose is approached from the same side; backlash and hysteresis there cannot "
        "be told from the joint's zero: add the same poses approached from the other side"
    ]


def _coarse(recording: Recording) -> list[str]:
    reach = float(recording.arm.link_lengths_mm.sum())
    return [lattice_note(lattice, reach) for lattice in command_lattices(recording.q_cmd)]


def lattice_note(lattice: Lattice, reach_mm: float) -> str:
    """Return what a coarse lattice of commands means, with its error at the tip of an arm of `reach_mm`."""
    step, std = lattice.step_rad, lattice.reading_std_rad
    return (
        f"joint {lattice.joint}: {lattice.on_lattice} of {lattice.poses} different commands lie on steps of "
        f"{np.degrees(step):.3g} deg ({step:.4g} rad): they were read or rounded that coarsely, which alone is an "
        f"error of {std:.2g} rad ({std * reach_mm:.2g} mm at the tip); nothing finer can be told"
    )
