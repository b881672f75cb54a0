"""A person's own table of commanded and measured angles, by a mapping of its columns."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from armtwin.models.csv_table import CsvTable, finite, read_csv
from armtwin.models.errors import InputError, nearest, shown
from armtwin.models.importers.log import JointLog, checked
from armtwin.models.importers.mapping import ANGLES, TIMES, UNKNOWN, AngleColumn, Mapping, propose, unknown_units
from armtwin.models.importers.units_of_values import told_by_values

Array = NDArray[np.float64]

_MAX_BYTES = 1 << 28
# Rows nearer in time than this sample a moving arm: no hobby servo moves, rests and is read so fast.
_MOVING_BELOW_S = 0.25


def read_table(path: Path) -> CsvTable:
    """Read the table; raises `InputError`."""
    if not path.is_file():
        raise InputError(f"{path}: no such file; a CSV of commanded and measured angles is wanted, or a folder of them")
    return read_csv(path, _MAX_BYTES, "one row a sample")


def read_tables(path: Path) -> list[CsvTable]:
    """Read a table, or each .csv of a folder, every one a motion; raises `InputError`."""
    files = sorted(path.glob("*.csv")) if path.is_dir() else []
    return [read_table(file) for file in files or [path]]


def proposed_mapping(table: CsvTable, unit: str | None = None) -> Mapping:
    """Propose which column is what, and from its times whether the arm moved; raises `InputError`.

    Angles whose unit no name tells are in `unit`, or in the one that their values can be of alone.
    """
    mapping = propose(table.columns, table.name, moving=False)
    times = None
    if mapping.time is not None:
        times = np.array([finite(table, row, mapping.time.column) for row in range(len(table))])
    angles = [one for joint in mapping.joints for one in (joint.command, joint.measured)]
    mapping = told_by_values(mapping, {one.column: _numbers(table, one.column) for one in angles}, times, unit)
    if mapping.time is None or mapping.time.unit == UNKNOWN or times is None:
        return mapping
    steps = np.diff(times) * TIMES[mapping.time.unit]
    moving = bool(len(steps)) and float(np.median(np.abs(steps))) < _MOVING_BELOW_S
    return mapping.model_copy(update={"motion": "moving" if moving else "settled"})


def without_a_unit(table: CsvTable) -> list[str]:
    """List the columns whose unit their names do not tell."""
    return unknown_units(propose(table.columns, table.name, moving=False))


def _numbers(table: CsvTable, column: str) -> Array:
    """(N,) numbers as they stand, NaN for an empty cell; raises `InputError` for one that is none."""
    has = [bool(table.text(row, column).strip()) for row in range(len(table))]
    return np.array([finite(table, row, column) if given else np.nan for row, given in enumerate(has)])


def log_of(table: CsvTable, mapping: Mapping) -> JointLog:
    """Return the log that the mapping makes of the table; raises `InputError` with line and column."""
    columns = [mapping.trajectory] if mapping.trajectory is not None else []
    columns += [] if mapping.time is None else [mapping.time.column]
    columns += [one.column for joint in mapping.joints for one in (joint.command, joint.measured)]
    for name in columns:
        if name not in table.columns:
            raise InputError(f"{table.name}: has no column '{shown(name)}'{nearest(name, table.columns)}")
    n = len(table)
    time = np.full(n, np.nan)
    if mapping.time is not None:
        time = TIMES[mapping.time.unit] * np.array([finite(table, row, mapping.time.column) for row in range(n)])
        time = time - time[0]
    elif mapping.motion == "moving":
        raise InputError(f'{table.name}: no column of times; a moving arm\'s log needs one (or motion = "settled")')
    names = np.full(n, Path(table.name).stem or "log")
    if mapping.trajectory is not None:
        names = np.array([table.text(row, mapping.trajectory).strip() or "unnamed" for row in range(n)], dtype=np.str_)
    used = set(columns)
    unused = [name for name in table.columns if name not in used]
    return checked(
        JointLog(
            joints=tuple(joint.name for joint in mapping.joints),
            time_s=time,
            trajectory=names,
            q_cmd=np.column_stack([_angles(table, joint.command, needed=True) for joint in mapping.joints]),
            q_meas=np.column_stack([_angles(table, joint.measured, needed=False) for joint in mapping.joints]),
            motion=mapping.motion,
            notes=(f"columns not used: {', '.join(map(shown, unused))}",) if unused else (),
        ),
        table.name,
    )


def _angles(table: CsvTable, one: AngleColumn, *, needed: bool) -> Array:
    scale = 2.0 * math.pi / one.counts_per_turn if one.counts_per_turn else ANGLES[one.unit]
    values = np.array([finite(table, row, one.column) for row in range(len(table))]) if needed else None
    return one.sign * scale * ((_numbers(table, one.column) if values is None else values) - one.offset)
