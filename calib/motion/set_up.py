"""Gross errors of a moving recording's set-up: joints that turn round, exchanged columns, degrees, whole turns, clocks.

They are found in the readings' likeness to the commands, told, and mended before anything is fitted.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from armtwin.calib.motion.likeness import Likeness, likeness
from armtwin.calib.motion.problem import grains
from armtwin.calib.motion.two_clocks import answers_early, clock_rate
from armtwin.models.recordings.moving import MovingRecording

Array = NDArray[np.float64]

# A joint follows commands whose speeds are so much like its own, and another's that are so much more so.
_FOLLOWS, _BETTER = 0.7, 0.2
_DEGREES = 180.0 / np.pi
# A gain that is this near to it is no gain but a unit.
_NEAR = 1.3
# Encoders of so many bits; a step in degrees is that of one to this share of a bit.
_BITS, _SAME_STEP = (10, 14), 0.003
# No joint turns so far from one row to the next, or stays so far from where it is sent.
_JUMP_RAD, _ASTRAY_RAD = 4.5, 1.0


@dataclass(frozen=True)
class SetUpFault:
    """What is plainly wrong with a set-up: its name in files, the joints (from 1), a sentence and the remedy."""

    error: str
    joints: tuple[int, ...]
    said: str
    remedy: str


@dataclass(frozen=True, eq=False)
class Mended:
    """A recording without the gross errors that were found in it."""

    recording: MovingRecording
    faults: tuple[SetUpFault, ...] = ()


def mended(recording: MovingRecording) -> Mended:
    """Return a recording without the gross errors of its set-up; in most nothing is found."""
    faults: list[SetUpFault] = []
    looks: tuple[Callable[[MovingRecording], tuple[MovingRecording, list[SetUpFault]]], ...]
    looks = (_all_in_degrees, _whole_turns, _by_likeness, _clocks)
    for look in looks:
        recording, found = look(recording)
        faults += found
    return Mended(recording, tuple(faults))


def _all_in_degrees(recording: MovingRecording) -> tuple[MovingRecording, list[SetUpFault]]:
    """Take readings whose steps are an encoder's in degrees for degrees, with their commands."""
    steps = grains(recording.q_meas)
    bits = np.log2(360.0 / np.maximum(steps, 1e-9))
    odd = (steps > 0.0) & (np.abs(bits - np.round(bits)) < _SAME_STEP) & (_BITS[0] <= bits) & (bits <= _BITS[1] + 0.1)
    seen = np.nanmax(recording.q_meas, axis=0) - np.nanmin(recording.q_meas, axis=0)
    # Where the commands are in radians, the readings alone are wrong, as the ratio of both says.
    joints = np.flatnonzero(odd & (seen < _DEGREES / 2 * np.ptp(recording.q_cmd, axis=0)))
    if not len(joints):
        return recording, []
    q_cmd, q_meas = recording.q_cmd.copy(), recording.q_meas.copy()
    q_cmd[:, joints] /= _DEGREES
    q_meas[:, joints] /= _DEGREES
    numbers = tuple(int(joint) + 1 for joint in joints)
    said = (
        f"the angles of joint{'s' if len(numbers) > 1 else ''} {', '.join(map(str, numbers))} are in degrees: they are "
        f"read in steps of {steps[joints[0]]:.4g}, a turn over {2 ** round(float(bits[joints[0]]))}"
    )
    remedy = "name the columns _deg"
    return replace(recording, q_cmd=q_cmd, q_meas=q_meas), [SetUpFault("degrees_for_radians", numbers, said, remedy)]


def _whole_turns(recording: MovingRecording) -> tuple[MovingRecording, list[SetUpFault]]:
    """Unwrap readings that jump by a whole turn and come back to where the commands are."""
    q_meas, faults = recording.q_meas.copy(), []
    for joint in range(recording.n_joints):
        known = np.flatnonzero(np.isfinite(q_meas[:, joint]))
        seen = q_meas[known, joint]
        turns = -np.round(np.diff(seen) / (2.0 * np.pi)) * (np.abs(np.diff(seen)) > _JUMP_RAD)
        if len(known) and turns.any():
            unwrapped = seen + 2.0 * np.pi * np.append(0.0, np.cumsum(turns))
            unwrapped -= 2.0 * np.pi * np.round(np.median(unwrapped - recording.q_cmd[known, joint]) / (2.0 * np.pi))
            if np.median(np.abs(unwrapped - recording.q_cmd[known, joint])) > _ASTRAY_RAD:
                continue
            q_meas[known, joint] = unwrapped
            row = int(known[1:][turns != 0][0])
            faults.append(
                SetUpFault(
                    "whole_turns",
                    (joint + 1,),
                    f"the measured angle of joint {joint + 1} jumps by a whole turn, first in row {row + 1}",
                    f"unwrap theta{joint + 1}_meas_rad",
                )
            )
    return (replace(recording, q_meas=q_meas) if faults else recording), faults


def _by_likeness(recording: MovingRecording) -> tuple[MovingRecording, list[SetUpFault]]:
    alike = likeness(recording)
    recording, faults = _exchanged(recording, alike)
    if faults:
        alike = likeness(recording)
    q_cmd, q_meas = recording.q_cmd.copy(), recording.q_meas.copy()
    for joint in np.flatnonzero(alike.moves & alike.turns):
        value, lag_s = alike.best(int(joint), int(joint))
        if abs(value) < _FOLLOWS:
            continue
        number = int(joint) + 1
        if value < 0.0:
            q_cmd[:, joint] *= -1.0
            said = f"joint {number} turns the other way than its commands say"
            remedy = f"change the sign of theta{number}_cmd_rad, or of theta{number}_meas_rad if that column is wrong"
            faults.append(SetUpFault("joint_reversed", (number,), said, remedy))
        size = _size(recording, int(joint), lag_s)
        for angles, factor, kind, column in (
            (q_meas, size, "measured", "meas"),
            (q_cmd, 1.0 / max(size, 1e-9), "commanded", "cmd"),
        ):
            if _DEGREES / _NEAR < factor < _DEGREES * _NEAR:
                angles[:, joint] /= _DEGREES
                said = f"the {kind} angles of joint {number} are in degrees, the others in radians"
                remedy = f"name the column theta{number}_{column}_deg"
                faults.append(SetUpFault("degrees_for_radians", (number,), said, remedy))
    return (replace(recording, q_cmd=q_cmd, q_meas=q_meas) if faults else recording), faults


def _exchanged(recording: MovingRecording, alike: Likeness) -> tuple[MovingRecording, list[SetUpFault]]:
    n, q_cmd, faults = recording.n_joints, recording.q_cmd.copy(), []
    value = np.array([[abs(alike.best(i, j)[0]) for j in range(n)] for i in range(n)])
    for one, other in combinations(np.flatnonzero(alike.moves & alike.turns).tolist(), 2):
        own, crossed = max(value[one, one], value[other, other]), min(value[one, other], value[other, one])
        if crossed > max(_FOLLOWS, own + _BETTER):
            q_cmd[:, [one, other]] = q_cmd[:, [other, one]]
            a, b = one + 1, other + 1
            said = f"joints {a} and {b} are exchanged: each follows the other's commands"
            remedy = f"exchange the columns theta{a}_cmd_rad and theta{b}_cmd_rad, or the two servos' numbers"
            faults.append(SetUpFault("joints_exchanged", (a, b), said, remedy))
    return (replace(recording, q_cmd=q_cmd) if faults else recording), faults


def _size(recording: MovingRecording, joint: int, lag_s: float) -> float:
    """Return how many radians a joint is read to turn for each that it is sent, at its delay."""
    seen = recording.q_meas[:, joint]
    known = np.isfinite(seen)
    given = recording.time_s if recording.commanded_s is None else np.maximum.accumulate(recording.commanded_s)
    held = np.clip(np.searchsorted(given, recording.time_s[known] - lag_s, side="right") - 1, 0, None)
    a, b = recording.q_cmd[held, joint], seen[known]
    spread = float(np.std(a))
    return float(np.std(b)) / spread if spread > 0.0 else 1.0


def _clocks(recording: MovingRecording) -> tuple[MovingRecording, list[SetUpFault]]:
    faults: list[SetUpFault] = []
    rate = clock_rate(recording)
    if rate is not None:
        recording = rate.put(recording)
        faults.append(SetUpFault("clock_rate", (), rate.said, "log both with one clock"))
    early_s = answers_early(recording)
    if early_s > 0.0:
        given = recording.time_s if recording.commanded_s is None else recording.commanded_s
        recording = replace(recording, commanded_s=given - early_s)
        said = (
            f"the arm answers about {1e3 * early_s:.0f} ms before it is told: the clocks of commands and readings "
            "differ, and of a delay nothing can be told"
        )
        faults.append(SetUpFault("clock_offset", (), said, "log both with one clock"))
    return recording, faults
