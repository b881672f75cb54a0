"""Every gross error of a set-up that is looked for: what it is called, its remedy, and the recording without it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from armtwin.calib.setup.remainder import Remainder
from armtwin.models.recordings.recording import Recording

Array = NDArray[np.float64]

# Named by the diagnosis itself; here it only keeps what looks like it from being named in its place.
OUT_OF_STEP = "command_shift"
_SHIFTS = (-3, -2, -1, 1, 2, 3)
_TO_RADIANS = np.pi / 180.0


@dataclass(frozen=True, eq=False)
class SetUpError:
    """A gross error of the set-up.

    Attributes:
        error: its name in files.
        joints: numbers of the joints that it concerns, from 1.
        said: one sentence for people.
        remedy: what to do about it.
        mend: returns a recording without it.

    """

    error: str
    joints: tuple[int, ...]
    said: str
    remedy: str
    mend: Callable[[Recording], Recording]


def hypotheses(recording: Recording, found: Remainder) -> Iterator[SetUpError]:
    """Yield what may be wrong with a recording that its drawing leaves `found` of."""
    n = recording.arm.n_joints
    moving = [joint for joint in range(n) if np.ptp(recording.q_cmd[:, joint]) > 1e-6]
    yield from (_reversed((joint,)) for joint in moving)
    if len(moving) > 1:
        yield _reversed(tuple(moving))
    yield from (_exchanged(*pair) for pair in combinations(moving, 2))
    if n > 1:
        yield _absolute("q_cmd")
    yield from _all_in_degrees("q_cmd", n, moving)
    yield from (_out_of_step(rows) for rows in _SHIFTS)
    if recording.markers_px:
        seen = [name for name in recording.arm.marker_names if name in recording.markers_px]
        yield from (_markers_exchanged(*pair) for pair in combinations(seen, 2))
        yield from (_mirrored(axis) for axis in (0, 1))
        return
    if n > 1:
        yield _absolute("q_meas")
    yield from _all_in_degrees("q_meas", n, moving)
    yield from _turned_round(recording, found)


def _reversed(joints: tuple[int, ...]) -> SetUpError:
    def mend(recording: Recording) -> Recording:
        q_cmd = recording.q_cmd.copy()
        q_cmd[:, list(joints)] *= -1.0
        return replace(recording, q_cmd=q_cmd)

    numbers = ", ".join(str(joint + 1) for joint in joints)
    columns = ", ".join(f"theta{joint + 1}_cmd_rad" for joint in joints)
    who = f"joint {numbers} turns" if len(joints) == 1 else f"joints {numbers} all turn"
    return SetUpError(
        "joint_reversed",
        tuple(joint + 1 for joint in joints),
        f"{who} the other way than the commands say",
        f"change the sign: direction in the bench file, or the sign of {columns}",
        mend,
    )


def _exchanged(one: int, other: int) -> SetUpError:
    def mend(recording: Recording) -> Recording:
        q_cmd = recording.q_cmd.copy()
        q_cmd[:, [one, other]] = q_cmd[:, [other, one]]
        return replace(recording, q_cmd=q_cmd)

    return SetUpError(
        "joints_exchanged",
        (one + 1, other + 1),
        f"joints {one + 1} and {other + 1} are exchanged: each follows the other's commands",
        f"exchange the two servos' cables, or columns theta{one + 1}_cmd_rad and theta{other + 1}_cmd_rad",
        mend,
    )


def _absolute(what: str) -> SetUpError:
    """Angles that are counted from the base, as a parallelogram arm's are."""
    kind = {"q_cmd": "commanded", "q_meas": "measured"}[what]

    def mend(recording: Recording) -> Recording:
        angles = getattr(recording, what)
        return replace(recording, **{what: np.diff(angles, axis=1, prepend=0.0)})

    return SetUpError(
        f"{kind}_angles_absolute",
        (),
        f"the {kind} angles are counted from the base, not each from the link before",
        f"take from every {kind} angle the one of the joint before",
        mend,
    )


def _all_in_degrees(what: str, n: int, moving: list[int]) -> Iterator[SetUpError]:
    """Yield angles in degrees: of all joints, and of each that moves."""
    if n > 1 and moving:
        yield _in_degrees(what, tuple(range(n)))
    yield from (_in_degrees(what, (joint,)) for joint in moving)


def _in_degrees(what: str, joints: tuple[int, ...]) -> SetUpError:
    kind, column = {"q_cmd": ("commanded", "cmd"), "q_meas": ("measured", "meas")}[what]

    def mend(recording: Recording) -> Recording:
        angles = getattr(recording, what).copy()
        angles[:, list(joints)] *= _TO_RADIANS
        return replace(recording, **{what: angles})

    numbers = ", ".join(str(joint + 1) for joint in joints)
    columns = ", ".join(f"theta{joint + 1}_{column}_deg" for joint in joints)
    some = len(joints) > 1
    return SetUpError(
        "degrees_for_radians",
        tuple(joint + 1 for joint in joints),
        f"the {kind} angles of joint{'s' if some else ''} {numbers} are in degrees",
        f"name the column{'s' if some else ''} {columns}, or multiply {'them' if some else 'it'} by pi/180",
        mend,
    )


def _out_of_step(rows: int) -> SetUpError:
    """Pictures, or readings, that stand beside a command some rows away."""

    def mend(recording: Recording) -> Recording:
        at = np.clip(np.arange(len(recording)) + rows, 0, len(recording) - 1)
        return replace(recording, q_cmd=recording.q_cmd[at])

    return SetUpError(OUT_OF_STEP, (), f"commands and what was seen are {abs(rows)} rows out of step", "", mend)


def _markers_exchanged(one: str, other: str) -> SetUpError:
    def mend(recording: Recording) -> Recording:
        markers = dict(recording.markers_px)
        markers[one], markers[other] = markers[other], markers[one]
        return replace(recording, markers_px=markers)

    return SetUpError(
        "markers_exchanged",
        (),
        f"markers {one.upper()} and {other.upper()} are exchanged in every row",
        f"exchange columns {one}_u_px, {one}_v_px with {other}_u_px, {other}_v_px",
        mend,
    )


def _mirrored(axis: int) -> SetUpError:
    side = ("left and right", "above and below")[axis]

    def mend(recording: Recording) -> Recording:
        assert recording.camera is not None
        size = (recording.camera.image_width, recording.camera.image_height)[axis]
        markers = {}
        for name, pixels in recording.markers_px.items():
            flipped = pixels.copy()
            flipped[:, axis] = size - 1 - flipped[:, axis]
            markers[name] = flipped
        return replace(recording, markers_px=markers)

    return SetUpError(
        "picture_mirrored",
        (),
        f"the pictures are mirrored: {side} are exchanged",
        "switch the camera's mirror off and record again, or mirror the pixels back",
        mend,
    )


def _turned_round(recording: Recording, found: Remainder) -> Iterator[SetUpError]:
    """Yield, for each joint, measured angles that are whole or half turns off in some rows."""
    assert recording.q_meas is not None
    for joint in range(recording.arm.n_joints):
        for step, words in ((2.0 * np.pi, "a whole turn"), (np.pi, "half a turn")):
            error = recording.q_meas[:, joint] - recording.q_cmd[:, joint]
            # The zero that most rows share, up to turns: the one nearest to the drawing's.
            zero = found.zeros_rad[joint] - step * np.round(found.zeros_rad[joint] / step)
            turns = np.nan_to_num(np.round((error - zero) / step))
            rows = np.flatnonzero(turns)
            if len(rows):
                angles = recording.q_meas[:, joint] - step * turns
                yield _whole_turns(joint, step, words, turns, recording.sample[rows], angles)


def _whole_turns(
    joint: int, step: float, words: str, turns: Array, samples: NDArray[np.int64], angles: Array
) -> SetUpError:
    def mend(recording: Recording) -> Recording:
        assert recording.q_meas is not None
        q_meas = recording.q_meas.copy()
        q_meas[:, joint] -= step * turns
        return replace(recording, q_meas=q_meas)

    where = _where(np.flatnonzero(turns), samples, turns, angles)
    return SetUpError(
        "whole_turns" if step > 4.0 else "half_turns",
        (joint + 1,),
        f"the measured angle of joint {joint + 1} is off by {words} {where}",
        f"unwrap theta{joint + 1}_meas_rad: add or take {words} there",
        mend,
    )


def _where(rows: NDArray[np.int64], samples: NDArray[np.int64], turns: Array, angles: Array) -> str:
    """Say in which rows an angle is turns off: from a sample on, between two, beyond an angle, or which ones."""
    if len(rows) == rows[-1] - rows[0] + 1:
        last = "on" if rows[-1] == len(turns) - 1 else f"to {samples[-1]}"
        return f"from sample {samples[0]} {last}"
    off, right = angles[rows], angles[turns == 0]
    if off.min() > right.max():
        return f"in {len(rows)} samples, wherever it is above {np.degrees(off.min()):.0f} degrees"
    if off.max() < right.min():
        return f"in {len(rows)} samples, wherever it is below {np.degrees(off.max()):.0f} degrees"
    return f"in {len(rows)} samples, {', '.join(map(str, samples[:5]))}{' ...' if len(rows) > 5 else ''}"
