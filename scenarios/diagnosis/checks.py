"""Recordings that cannot be diagnosed, refused in one line; and what a recording that can be cannot tell, in notes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from armtwin.calib.diagnosis.grain import Grain, reading_grains
from armtwin.calib.diagnosis.lattice import Lattice, command_lattices
from armtwin.models.errors import RecordingError
from armtwin.models.recordings.recording import Recording

Array = NDArray[np.float64]

# With fewer poses order, angle and direction of approach are one and the same: a joint there and back in four steps.
_LEAST_POSES = 8
# A hobby servo needs longer than this from one pose to rest in the next, and a picture of it.
_REST_S = 0.12
# So many rows are a log, and it moves in at least so many of them.
_LEAST_LOG, _LEAST_MOVES = 60, 8
# Moves below this are no moves: a command repeated.
_STILL_RAD = 1e-6


def check_recording(recording: Recording) -> None:
    """Raise `RecordingError` where nothing, or nothing but by chance, can be told.

    Too few poses, nothing seen, a reading or a clock that is stuck while the arm moves. A command that never changes,
    or a joint that never turns back, is none of these: other things can be told of it (`notes_on`).
    """
    arm = recording.arm
    missing = _LEAST_POSES - len(recording)
    if missing > 0:
        raise RecordingError(
            f"samples.csv: too short to decide: {len(recording)} poses, at least {_LEAST_POSES} are wanted; add "
            f"{missing} poses"
        )
    _refuse_stuck_clock(recording)
    _refuse_motion(recording)
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
        axis = arm.links_to(name)
        if axis > first:  # what lies on or before the first moving axis may well stand still
            _refuse_stuck(pixels, f"{name}_u_px and {name}_v_px", f"theta{first + 1}_cmd_rad")


def notes_on(recording: Recording) -> list[str]:
    """Return what this recording cannot tell whatever is found, one line each."""
    return [*_constant(recording), *_one_sided(recording), *_coarse(recording), *_seldom_seen(recording)]


def part_note(looked_at: int, whole: int) -> list[str]:
    """Say of how many poses the diagnosis is, where there are more than are looked at."""
    if looked_at == whole:
        return []
    return [
        f"{looked_at} of {whole} poses were looked at, in runs spread evenly over the recording: what happened between "
        "them alone was not seen, and a sample named here is counted among these"
    ]


# Markers that are missed in fewer poses than this share are as good as seen.
_SELDOM = 0.05


def _seldom_seen(recording: Recording) -> list[str]:
    """Say of each marker in how many poses it was seen, and from when on it was not, where it was missed in many."""
    lines = []
    for name, pixels in recording.markers_px.items():
        seen: NDArray[np.bool_] = np.asarray(np.isfinite(pixels).all(axis=-1))
        if not seen.any() or seen.mean() > 1.0 - _SELDOM:
            continue
        last = int(np.flatnonzero(seen)[-1])
        gone = "" if last == len(seen) - 1 else f", and never from sample {recording.sample[last + 1]} on"
        lines.append(
            f"marker {name.upper()} was seen in {seen.sum()} of {len(seen)} poses and not in {(~seen).sum()}{gone}: "
            "what happened there is told by the other markers alone"
        )
    return lines


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


def _way(signs: Array) -> str:
    return "grows" if signs[0] > 0 else "falls"


def _refuse_motion(recording: Recording) -> None:
    """Refuse rows that sample a moving arm: taken for poses at rest, their lag is named as a shift or a slip."""
    if not recording.has_time or len(recording) < _LEAST_LOG:
        return
    moving = np.abs(np.diff(recording.q_cmd, axis=0)).max(axis=1) > _STILL_RAD
    if moving.sum() < _LEAST_MOVES:
        return
    apart = float(np.median(np.diff(recording.time_s)[moving]))
    if 0 < apart < _REST_S:
        raise RecordingError(
            f"samples.csv: rows are {apart:.3g} s apart while the arm moves, a log of motion and not of poses at rest, "
            'which no servo reaches so fast; say "motion": "moving" in recording.json to have it diagnosed as that'
        )


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
    """Joints that always turn the same way: play and friction only shift their zero.

    Where no joint turns back, what grows with the order of poses is one with what grows with the angle, too.
    """
    ways = {joint: signs for joint, signs in enumerate(_turns(recording), start=1) if len(signs)}
    one_way = {joint: signs for joint, signs in ways.items() if len(signs) == 1}
    if not one_way:
        return []
    joints = ", ".join(map(str, one_way))
    if len(one_way) < len(ways):
        return [
            f"joint {joints}: every pose is approached from the same side; backlash and hysteresis there cannot be "
            "told from the joint's zero: add the same poses approached from the other side"
        ]
    swept = ", ".join(f"theta{joint}_cmd_rad only {_way(signs)}" for joint, signs in one_way.items())
    return [
        f"no joint ever turns back ({swept}): backlash and hysteresis are one with a joint's zero, and what creeps or "
        "jumps with the order of poses is one with its gain and curve; neither was looked for: add the same poses in "
        "reverse order"
    ]


def _coarse(recording: Recording) -> list[str]:
    reach = float(recording.arm.link_lengths_mm.sum())
    commands = [lattice_note(lattice, reach) for lattice in command_lattices(recording.q_cmd)]
    return [*commands, *(grain_note(grain, reach) for grain in reading_grains(recording))]


def grain_note(grain: Grain, reach_mm: float) -> str:
    """Return what the steps of readings mean, with their error at the tip of an arm of `reach_mm`."""
    if grain.channel == "pixels":
        return (
            f"the pixels are rounded to steps of {grain.step:g} px, which alone is noise of {grain.std:.2g} px a "
            "coordinate; write them with four decimals"
        )
    return (
        f"{grain.channel}: the measured angles lie on steps of {np.degrees(grain.step):.3g} deg, the grain of the "
        f"reading: no noise below {np.degrees(grain.std):.2g} deg ({grain.std * reach_mm:.2g} mm at the tip) is "
        "believed, and what only these steps explain is not the arm's"
    )


def lattice_note(lattice: Lattice, reach_mm: float) -> str:
    """Return what a coarse lattice of commands means, with its error at the tip of an arm of `reach_mm`."""
    step, std = lattice.step_rad, lattice.reading_std_rad
    return (
        f"joint {lattice.joint}: {lattice.on_lattice} of {lattice.poses} different commands lie on steps of "
        f"{np.degrees(step):.3g} deg ({step:.4g} rad): they were read or rounded that coarsely, which alone is an "
        f"error of {std:.2g} rad ({std * reach_mm:.2g} mm at the tip); nothing finer can be told"
    )
