"""A person's own table of commanded and measured angles, by a mapping of its columns."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from armtwin.models.csv_table import CsvTable, finite, read_csv
from armtwin.models.errors import InputError, nearest, shown
from armtwin.models.importers.log import JointLog, checked
from armtwin.models.importers.mapping import ANGLES, TIMES, AngleColumn, Mapping, propose

Array = NDArray[np.float64]

_MAX_BYTES = 1 << 28
# Rows nearer in time than this sample a moving arm: no hobby servo moves, rests and is read so fast.
_MOVING_BELOW_S = 0.25


def read_table(path: Path) -> CsvTable:
    """Read the table; raises `InputError`."""
    if not path.is_file():
        raise InputError(f"{path}: no such file; a CSV of commanded and measured angles is wanted")
    return read_csv(path, _MAX_BYTES, "one row a sample")


def proposed_mapping(table: CsvTable) -> Mapping:
    """Propose which column is what, and from its times whether the arm moved; raises `InputError`."""
    mapping = propose(table.columns, table.name, moving=False)
    if mapping.time is None or mapping.time.unit == "?":
        return mapping
    scale = TIMES[mapping.time.unit]
    times = np.array([finite(table, row, mapping.time.column) for row in range(len(table))])
    steps = np.diff(times) * scale
    moving = bool(len(steps)) and float(np.median(steps)) < _MOVING_BELOW_S
    return mapping.model_copy(update={"motion": "moving" if moving else "settled"})


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
    out = np.full(len(table), np.nan)
    for row in range(len(table)):
        if needed or table.text(row, one.column).strip():
            out[row] = one.sign * scale * (finite(table, row, one.column) - one.offset)
    return out
