"""What every importer makes: commanded and measured joint angles over time, and how it came to them."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from armtwin.models.errors import InputError, nearest, shown

Array = NDArray[np.float64]

# A recording knows planar arms of so many joints.
MOST_JOINTS = 6
# Logs of two hours at 500 Hz; more does not fit a person's patience, and hardly the memory.
MOST_ROWS = 4_000_000


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
    if len(log.joints) > MOST_JOINTS:
        raise InputError(
            f"{file}: {len(log.joints)} joints ({', '.join(map(shown, log.joints))}), a recording has 1 to "
            f"{MOST_JOINTS}; choose with --joints"
        )
    if not np.isfinite(log.q_cmd).all():
        row = int(np.argmin(np.isfinite(log.q_cmd).all(axis=1)))
        raise InputError(f"{file}: row {row + 1}: a command is no finite number")
    if log.motion == "moving":
        same = log.trajectory[1:] == log.trajectory[:-1]
        back = np.flatnonzero(same & ~(np.diff(log.time_s) > 0))
        if len(back):
            row = int(back[0]) + 1
            raise InputError(
                f"{file}: row {row + 1}: {log.time_s[row]:g} s after {log.time_s[row - 1]:g} s; times increase in a "
                "moving recording"
            )
    turned = np.abs(log.q_cmd).max()
    if turned > 2 * np.pi:
        joint = int(np.abs(log.q_cmd).max(axis=0).argmax())
        raise InputError(
            f"{file}: joint '{shown(log.joints[joint])}' is commanded to {np.degrees(turned):.0f} degrees, more than a "
            "whole turn; is its unit another one?"
        )
    return log


def in_force(command_s: Array, commands: Array, seen_s: Array) -> tuple[Array, Array, NDArray[np.bool_]]:
    """Return the last command (N, n) given at or before each row, when it was given (N,), and which rows have one."""
    order = np.argsort(command_s, kind="stable")
    number = np.searchsorted(command_s[order], seen_s, side="right") - 1
    has = number >= 0
    number = np.maximum(number, 0)
    return commands[order][number], command_s[order][number], has
