"""Which column of a person's table is what (`armtwin.mapping/1`): proposed from the header, or read from a file.

    schema = "armtwin.mapping/1"
    motion = "moving"                                  # or "settled": rows are poses at rest
    time = { column = "t_ms", unit = "ms" }
    trajectory = "run"                                 # a column of names
    [[joints]]
    name = "shoulder"
    command = { column = "shoulder_target", unit = "deg" }
    measured = { column = "shoulder_actual", unit = "deg", sign = -1, offset = 90.0 }

A value is read as sign * (cell - offset) in its unit.
"""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Annotated, Any, Literal

import tomli_w
from pydantic import Field

from armtwin.models.errors import InputError, shown
from armtwin.models.toml_reader import read_toml
from armtwin.models.validation import Finite, Positive, Strict, check

SCHEMA = "armtwin.mapping/1"
# The place of a unit that nobody has told yet.
UNKNOWN = "?"
ANGLES = {"rad": 1.0, "deg": math.pi / 180.0, "mrad": 1e-3, "turn": 2.0 * math.pi}
TIMES = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
_COMMANDS = frozenset(
    {
        *("cmd", "command", "commanded", "target", "goal"),
        *("desired", "reference", "ref", "action", "setpoint", "soll"),
    }
)
_MEASURED = frozenset(
    {
        *("meas", "measured", "actual", "position", "pos"),
        *("state", "observed", "present", "encoder", "feedback", "ist"),
    }
)
_TIMES = ("time", "timestamp", "t", "stamp", "zeit", "elapsed")
_NAMES = ("trajectory", "run", "episode", "motion", "segment")
_UNIT_WORDS = {
    **{"rad": "rad", "radians": "rad", "deg": "deg", "degrees": "deg", "degree": "deg", "°": "deg", "grad": "deg"},
    **{"mrad": "mrad", "turn": "turn", "turns": "turn", "rev": "turn"},
}
_TIME_WORDS = {
    **{
        "s": "s",
        "sec": "s",
        "seconds": "s",
        "ms": "ms",
        "millis": "ms",
        "us": "us",
        "µs": "us",
        "micros": "us",
        "ns": "ns",
    }
}

ColumnName = Annotated[str, Field(min_length=1, max_length=200)]


class AngleColumn(Strict):
    """A column of angles: q = sign (cell - offset) in its unit; counts need `counts_per_turn`."""

    column: ColumnName
    unit: Literal["rad", "deg", "mrad", "turn", "counts", "?"]
    sign: Literal[-1, 1] = 1
    offset: Finite = 0.0
    counts_per_turn: Positive | None = None


class TimeColumn(Strict):
    """A column of times."""

    column: ColumnName
    unit: Literal["s", "ms", "us", "ns", "?"]


class JointColumns(Strict):
    """The columns of one joint."""

    name: Annotated[str, Field(min_length=1, max_length=100)]
    command: AngleColumn
    measured: AngleColumn


class Mapping(Strict):
    """A whole mapping."""

    schema_: Literal["armtwin.mapping/1"] = Field(alias="schema")
    motion: Literal["settled", "moving"]
    time: TimeColumn | None = None
    trajectory: ColumnName | None = None
    joints: Annotated[list[JointColumns], Field(min_length=1, max_length=7)]


def read_mapping(path: Path) -> Mapping:
    """Read a mapping file; raises `InputError`, also where a unit is still to be told."""
    mapping = check(Mapping, read_toml(path), path.name)
    unknown = unknown_units(mapping)
    if unknown:
        raise InputError(f"{path.name}: the unit of column '{shown(unknown[0])}' is '?'; write rad, deg, counts, s, …")
    for joint in mapping.joints:
        for one in (joint.command, joint.measured):
            if (one.unit == "counts") != (one.counts_per_turn is not None):
                raise InputError(f"{path.name}: column '{shown(one.column)}': counts and counts_per_turn go together")
    return mapping


def mapping_text(mapping: Mapping) -> str:
    """Return the content of a mapping file."""
    return tomli_w.dumps(mapping.model_dump(by_alias=True, exclude_none=True))


def unknown_units(mapping: Mapping) -> list[str]:
    """List the columns whose unit the header does not tell."""
    found = [one for joint in mapping.joints for one in (joint.command, joint.measured) if one.unit == UNKNOWN]
    names = [one.column for one in found]
    return names + ([mapping.time.column] if mapping.time is not None and mapping.time.unit == UNKNOWN else [])


def propose(columns: list[str], file: str, moving: bool) -> Mapping:
    """Propose a mapping from a header; a unit that no name tells is '?', for a person to fill in.

    Raises `InputError` where commanded and measured columns cannot be paired.
    """
    commands: dict[str, tuple[str, str]] = {}
    measured: dict[str, tuple[str, str]] = {}
    time: dict[str, Any] | None = None
    trajectory = None
    for column in columns:
        words = _words(column)
        if time is None and any(word in _TIMES for word in words):
            units = [_TIME_WORDS[word] for word in words if word in _TIME_WORDS]
            time = {"column": column, "unit": units[-1] if units else UNKNOWN}
        elif trajectory is None and any(word in _NAMES for word in words):
            trajectory = column
        else:
            unit = next((_UNIT_WORDS[word] for word in reversed(words) if word in _UNIT_WORDS), UNKNOWN)
            for kind, found in ((_COMMANDS, commands), (_MEASURED, measured)):
                if any(word in kind for word in words):
                    key = "_".join(w for w in words if w not in kind and w not in _UNIT_WORDS)
                    found.setdefault(key, (column, unit))
                    break
    joints = [name for name in commands if name in measured]
    if not joints:
        listed = ", ".join(shown(column) for column in columns[:20])
        raise InputError(
            f"{file}: no column of commands goes with one of readings; name them (elbow_target_deg, elbow_actual_deg) "
            f"or write a mapping file (--mapping). Its columns: {listed}"
        )
    if len(joints) > 7:
        raise InputError(f"{file}: {len(joints)} joints ({', '.join(map(shown, joints))}); choose in a mapping file")
    table: dict[str, Any] = {"schema": SCHEMA, "motion": "moving" if moving else "settled"}
    if time is not None:
        table["time"] = time
    if trajectory is not None:
        table["trajectory"] = trajectory
    table["joints"] = [
        {
            "name": name or "joint1",
            "command": dict(zip(("column", "unit"), commands[name], strict=True)),
            "measured": dict(zip(("column", "unit"), measured[name], strict=True)),
        }
        for name in joints
    ]
    return check(Mapping, table, file)


def _words(column: str) -> list[str]:
    """Split a column's name at signs and capitals: 'elbowTarget [deg]' is elbow, target, deg."""
    spaced = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", " ", column[:200])
    return [word for word in re.split(r"[^a-z0-9°µ]+", spaced.lower()) if word]
