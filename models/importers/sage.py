"""SAGE logs: a motion's `control.csv` and `state_motor.csv`, lists of radians in quoted cells.

Times are in µs in real logs and in s in simulated ones. The "torques" are magnitudes of currents times a constant, no
torques, and are left out.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from armtwin.models.csv_table import CsvTable, finite, read_csv
from armtwin.models.errors import InputError
from armtwin.models.importers.clocks import on_clock_of
from armtwin.models.importers.log import JointLog, checked, in_force, joined

Array = NDArray[np.float64]

_CONTROL = "control.csv"
_MAX_BYTES = 1 << 28
_MAX_NAMES_BYTES = 1 << 16
# No log has a row every 50 s, or one every 50 µs.
_SLOWEST_S = 50.0


def read_sage(folder: Path, names: list[str] | None = None) -> JointLog:
    """Read a motion's folder, or a folder of such, each a trajectory.

    `names` are those of the joints where no joint_list.txt gives them. Raises `InputError`.
    """
    inside = sorted(path.parent for path in folder.glob(f"*/{_CONTROL}"))
    if inside and not (folder / _CONTROL).is_file():
        return joined([_motion(one, names) for one in inside])
    return _motion(folder, names)


def _motion(folder: Path, names: list[str] | None) -> JointLog:
    control, state = (_table(folder / name) for name in (_CONTROL, "state_motor.csv"))
    command, measured = _lists(control, "positions"), _lists(state, "positions")
    n = measured.shape[1]
    if command.shape[1] != n:
        raise InputError(f"{control.name}: {command.shape[1]} positions a row, {state.name} has {n}")
    joints = _joints(folder, names, n)
    command_s, seen_s = _times(control), _times(state)
    scales = [_unit(one) for one in (command_s, seen_s)]
    start = scales[1][0] * seen_s[0]
    command_s, seen_s = scales[0][0] * command_s - start, scales[1][0] * seen_s - start
    notes = [f"times are in {scales[1][1]}", "torques are currents' magnitudes and left out"]
    command_s, moved = on_clock_of(seen_s, measured, command_s, command, folder.name)
    q_cmd, given, has = in_force(command_s, command, seen_s)
    notes += [] if moved is None else [moved]
    if not has.all():
        notes.append(f"{int((~has).sum())} rows before the first command are left out")
    extras = {}
    if "velocities" in state.columns:
        extras["vel_rad_s"] = _lists(state, "velocities")[has]
    log = JointLog(
        joints=joints,
        time_s=seen_s[has],
        trajectory=np.full(int(has.sum()), folder.resolve().name or "motion"),
        q_cmd=q_cmd[has],
        q_meas=measured[has],
        commanded_s=given[has],
        extras=extras,
        notes=tuple(notes),
    )
    grippers = [name for name in joints if "gripper" in name]
    kept = log.chosen([name for name in joints if name not in grippers]) if grippers else log
    return checked(kept, folder.name)


def _table(path: Path) -> CsvTable:
    if not path.is_file():
        raise InputError(
            f"{path}: no such file; a SAGE motion, or each in a folder of them, has control.csv and state_motor.csv"
        )
    table = read_csv(path, _MAX_BYTES, "one row a sample")
    for name in ("timestamp", "positions"):
        if name not in table.columns:
            raise InputError(f"{path.name}: column '{name}' is missing; SAGE has type, timestamp, positions")
    return table


def _times(table: CsvTable) -> Array:
    return np.array([finite(table, row, "timestamp") for row in range(len(table))])


def _lists(table: CsvTable, column: str) -> Array:
    rows: list[list[float]] = []
    for row in range(len(table)):
        text = table.text(row, column).strip().strip("[]()")
        try:
            values = [float(word) for word in text.replace(",", " ").split()]
        except ValueError:
            values = []
        if not values or not np.isfinite(values).all() or (rows and len(values) != len(rows[0])):
            wanted = f"{len(rows[0])} numbers" if rows else "a list of numbers"
            raise InputError(f"{table.at(row, column)}: '{text[:40]}', {wanted} is wanted")
        rows.append(values)
    return np.array(rows)


def _joints(folder: Path, names: list[str] | None, n: int) -> tuple[str, ...]:
    listed = folder / "joint_list.txt"
    if names is None and listed.is_file():
        if listed.stat().st_size > _MAX_NAMES_BYTES:
            raise InputError(f"{listed.name}: larger than {_MAX_NAMES_BYTES} bytes")
        names = [line.strip() for line in listed.read_text("utf-8", "replace").splitlines() if line.strip()]
    if names is None:
        return tuple(f"joint{i + 1}" for i in range(n))
    if len(names) != n:
        raise InputError(f"{folder.name}: {len(names)} joints are named, its rows hold {n}")
    return tuple(names)


def _unit(time: Array) -> tuple[float, str]:
    step = float(np.median(np.diff(time))) if len(time) > 1 else 1.0
    return (1e-6, "µs") if step > _SLOWEST_S else (1.0, "s")
