"""A recording of a moving arm in memory: commanded and measured joint angles over time, motion after motion."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from armtwin.models.arm import Arm
from armtwin.models.tabular import html_table

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class ModelArm:
    """An arm that is given by a model of its own.

    Attributes:
        name: what the recording calls it.
        joints: names of its n joints in the model, `theta1` first.
        model: the MJCF or URDF file.

    """

    name: str
    joints: tuple[str, ...]
    model: Path

    @property
    def n_joints(self) -> int:
        """Number of joints."""
        return len(self.joints)


@dataclass(frozen=True, eq=False)
class MovingRecording:
    """Rows of a moving arm, in the order they happened.

    Attributes:
        arm: link lengths of a planar arm, or a model.
        time_s: (N,) when each row was seen, s, growing.
        trajectory: (N,) names; each is a motion of its own, and the arm starts each from where it was measured first.
        q_cmd: (N, n) commands, rad; a row's is given after the row was read and stays in force until the next.
        q_meas: (N, n) measured angles, rad, NaN where missing.
        commanded_s: (N,) when each command was given where that was not at its row's time, or None.
        extras: further columns (N, n) by their ending: `torque_nm`, `current_a`, `vel_rad_s`; and `supply_v` (N,).
        payload_kg: (N,) a known mass at the tip, or None.
        temperature_c: (N,) or None.
        clock: whether times were measured, or made from a row's number and a nominal rate.
        servo: the servos' registers by name, one value a joint.
        settings: what of them, and of `payload_kg`, is another in a trajectory.
        held_out: trajectories to be kept for validation; empty where the file names none.
        folder: where it was read from.

    """

    arm: Arm | ModelArm
    time_s: Array
    trajectory: NDArray[np.str_]
    q_cmd: Array
    q_meas: Array
    commanded_s: Array | None = None
    extras: Mapping[str, Array] = field(default_factory=dict)
    payload_kg: Array | None = None
    temperature_c: Array | None = None
    clock: Literal["measured", "synthetic"] = "measured"
    servo: Mapping[str, tuple[float | None, ...]] = field(default_factory=dict)
    settings: Mapping[str, Mapping[str, object]] = field(default_factory=dict)
    held_out: tuple[str, ...] = ()
    folder: Path | None = None

    def __len__(self) -> int:
        return len(self.time_s)

    @property
    def n_joints(self) -> int:
        """Number of joints."""
        return self.q_cmd.shape[1]

    @property
    def joint_names(self) -> tuple[str, ...]:
        """What people call the joints."""
        if isinstance(self.arm, ModelArm):
            return self.arm.joints
        return tuple(f"joint {number + 1}" for number in range(self.n_joints))

    @cached_property
    def first(self) -> NDArray[np.bool_]:
        """(N,) whether a motion begins at a row."""
        return np.append(True, self.trajectory[1:] != self.trajectory[:-1])

    @cached_property
    def motions(self) -> tuple[str, ...]:
        """The trajectories in their order."""
        return tuple(str(name) for name in self.trajectory[self.first])

    def columns(self) -> dict[str, NDArray[Any]]:
        """Return the columns of `samples.csv` by name, (N,) each, NaN where a cell is empty."""
        joints = range(self.n_joints)
        out: dict[str, NDArray[Any]] = {
            "sample": np.arange(len(self)),
            "time_s": self.time_s,
            "trajectory": self.trajectory,
        }
        for kind, angles in (("cmd", self.q_cmd), ("meas", self.q_meas)):
            out |= {f"theta{i + 1}_{kind}_rad": angles[:, i] for i in joints}
        for ending, values in self.extras.items():
            of_row = values.ndim == 1
            out |= {ending: values} if of_row else {f"theta{i + 1}_{ending}": values[:, i] for i in joints}
        rows = ("commanded_s", "payload_kg", "temperature_c")
        return out | {name: getattr(self, name) for name in rows if getattr(self, name) is not None}

    def _repr_html_(self) -> str:
        title = f"Moving recording of '{self.arm.name}': {len(self)} rows, {len(self.motions)} motions"
        return html_table(title, self.columns())

    def rows_of(self, motion: str) -> NDArray[np.intp]:
        """Return the rows of a motion."""
        return np.flatnonzero(self.trajectory == motion)
