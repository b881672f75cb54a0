"""What every importer makes: commanded and measured joint angles over time, and how it came to them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from armtwin.models.errors import InputError, nearest, shown

Array = NDArray[np.float64]

# A recording knows poses of planar arms of so many joints, and motions of any arm of one more.
MOST_JOINTS = {"settled": 6, "moving": 7}
# Logs of two hours at 500 Hz; more does not fit a person's patience, and hardly the memory.
MOST_ROWS = 4_000_000
# Between motions whose clocks begin anew: an arm rests long before.
_BETWEEN_S = 5.0


@dataclass(frozen=True, eq=False)
class JointLog:
    """A log of an arm's joints, one row a sample, SI units.

    Attributes:
        joints: names of the n joints, base first.
        time_s: (N,) when each row was seen, s from the first; NaN where time was not recorded.
        trajectory: (N,) names; time may jump between them.
        q_cmd: (N, n) command in force from each row on, rad.
        q_meas: (N, n) measured angles, rad, NaN where missing.
        commanded_s: (N,) when the command was given, or None where it was with the row.
        extras: further columns (N, n) by their ending: `vel_rad_s`, `torque_nm`, `current_a`.
        motion: whether rows are poses at rest or samples of a moving arm.
        clock: whether times were measured, or made from a row's number and a nominal rate.
        notes: what was taken for what, and what was left out.

    """

    joints: tuple[str, ...]
    time_s: Array
    trajectory: NDArray[np.str_]
    q_cmd: Array
    q_meas: Array
    commanded_s: Array | None = None
    extras: dict[str, Array] = field(default_factory=dict)
    motion: Literal["settled", "moving"] = "moving"
    clock: Literal["measured", "synthetic"] = "measured"
    notes: tuple[str, ...] = ()

    def __len__(self) -> int:
        return len(self.time_s)

    def chosen(self, joints: list[str] | None) -> JointLog:
        """Return the log of these joints alone, in this order; raises `InputError` for a name that it does not have."""
        if joints is None:
            return self
        for name in joints:
            if name not in self.joints:
                raise InputError(f"--joints: there is no joint '{shown(name)}'{nearest(name, self.joints)}")
        columns = [self.joints.index(name) for name in joints]
        left = [name for name in self.joints if name not in joints]
        return replace(
            self,
            joints=tuple(joints),
            q_cmd=self.q_cmd[:, columns],
            q_meas=self.q_meas[:, columns],
            extras={name: values[:, columns] for name, values in self.extras.items()},
            notes=(*self.notes, *([f"left out: {', '.join(left)}"] if left else [])),
        )


def checked(log: JointLog, file: str) -> JointLog:
    """Return the log; raises `InputError` where it has no rows, too many joints, or times that run backwards."""
    if not len(log):
        raise InputError(f"{file}: no rows")
    if len(log.joints) > MOST_JOINTS[log.motion]:
        raise InputError(
            f"{file}: {len(log.joints)} joints ({', '.join(map(shown, log.joints))}), a recording has 1 to "
            f"{MOST_JOINTS[log.motion]}; choose with --joints"
        )
    if not np.isfinite(log.q_cmd).all():
        row = int(np.argmin(np.isfinite(log.q_cmd).all(axis=1)))
        raise InputError(f"{file}: row {row + 1}: a command is no finite number")
    if log.motion == "moving":
        if not np.isfinite(log.time_s).all():
            row = int(np.argmin(np.isfinite(log.time_s)))
            raise InputError(
                f"{file}: row {row + 1}: its time is missing; a moving arm's log needs the time of every row"
            )
        same = log.trajectory[1:] == log.trajectory[:-1]
        back = np.flatnonzero(same & ~(np.diff(log.time_s) > 0))
        if len(back):
            row = int(back[0]) + 1
            raise InputError(
                f"{file}: row {row + 1}: {log.time_s[row]:g} s after {log.time_s[row - 1]:g} s; times increase in a "
                "moving recording; where a new motion begins there, give it a name of its own in a column 'run'"
            )
        log = one_after_another(log)
    turned = np.abs(log.q_cmd).max()
    if turned > 2 * np.pi:
        joint = int(np.abs(log.q_cmd).max(axis=0).argmax())
        raise InputError(
            f"{file}: joint '{shown(log.joints[joint])}' is commanded to {np.degrees(turned):.0f} degrees, more than a "
            "whole turn; is its unit another one?"
        )
    return log


def one_after_another(log: JointLog) -> JointLog:
    """Return the log with motions whose clocks begin anew laid one after another, which is noted."""
    begins = np.flatnonzero(log.trajectory[1:] != log.trajectory[:-1]) + 1
    if not (log.time_s[begins] <= log.time_s[begins - 1]).any():
        return log
    shift, parts = np.zeros(len(log)), np.split(log.time_s, begins)
    for row, before, part in zip(begins, parts[:-1], parts[1:], strict=True):
        shift[row:] = shift[row - 1] + before[-1] + _BETWEEN_S - part[0]
    given = None if log.commanded_s is None else log.commanded_s + shift
    note = f"each trajectory's clock begins anew: they are laid {_BETWEEN_S:g} s apart"
    return replace(log, time_s=log.time_s + shift, commanded_s=given, notes=(*log.notes, note))


def joined(logs: Sequence[JointLog]) -> JointLog:
    """Return the motions of several logs of one arm as one; raises `InputError` where their joints differ."""
    first = logs[0]
    for log in logs[1:]:
        if log.joints != first.joints:
            raise InputError(
                f"{shown(str(log.trajectory[0]))}: its joints are {', '.join(map(shown, log.joints))}, those of "
                f"{shown(str(first.trajectory[0]))} {', '.join(map(shown, first.joints))}; import them apart"
            )
    given = [log.time_s if log.commanded_s is None else log.commanded_s for log in logs]
    shared = [name for name in first.extras if all(name in log.extras for log in logs)]
    return one_after_another(
        replace(
            first,
            time_s=np.concatenate([log.time_s for log in logs]),
            trajectory=np.concatenate([log.trajectory for log in logs]),
            q_cmd=np.concatenate([log.q_cmd for log in logs]),
            q_meas=np.concatenate([log.q_meas for log in logs]),
            commanded_s=None if all(log.commanded_s is None for log in logs) else np.concatenate(given),
            extras={name: np.concatenate([log.extras[name] for log in logs]) for name in shared},
            notes=tuple(dict.fromkeys(note for log in logs for note in log.notes)),
        )
    )


def in_force(command_s: Array, commands: Array, seen_s: Array) -> tuple[Array, Array, NDArray[np.bool_]]:
    """Return the last command (N, n) given at or before each row, when it was given (N,), and which rows have one."""
    order = np.argsort(command_s, kind="stable")
    number = np.searchsorted(command_s[order], seen_s, side="right") - 1
    has = number >= 0
    number = np.maximum(number, 0)
    return commands[order][number], command_s[order][number], has
