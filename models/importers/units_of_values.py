"""What a column's values say of its unit, for a person to agree to: whole counts of a turn, degrees or radians."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from armtwin.models.importers.mapping import UNKNOWN, AngleColumn, Mapping

Array = NDArray[np.float64]

# Feetech's and Dynamixel's encoders: 4096 counts a turn, the middle at 2048. Fewer are other turns, or other things.
_COUNTS, _MORE_THAN = 4096, 1023
_SAID = {"counts": {"unit": "counts", "counts_per_turn": float(_COUNTS), "offset": _COUNTS / 2.0}}
# Degrees of a turn and a bit.
_MOST_DEGREES = 400.0
# An arm whose log is in radians turns some joint by so much; one in degrees would have moved a hundredth of a turn.
_LEAST_RAD = 0.1
# Rows are nearer than this, s, and further apart than that, in the unit before: 0.5 s is 500 ms, 0.5 ms is 500 µs.
_TIME_STEPS = (("s", 0.5), ("ms", 500.0), ("us", 5e5), ("ns", 5e8))


def told_by_values(mapping: Mapping, angles: dict[str, Array], time: Array | None, unit: str | None = None) -> Mapping:
    """Return the mapping with the units that values tell where no name did.

    `angles` are the values of each angle's column, `time` those of the times, in the file's own units; `unit` is what
    somebody says that angles are in.
    """
    columns = [one for joint in mapping.joints for one in (joint.command, joint.measured) if one.unit == UNKNOWN]
    update: dict[str, Any] = {}
    found: dict[str, Any] | None = None
    if columns:
        found = (
            _angle([angles[one.column] for one in columns]) if unit is None else dict(_SAID.get(unit, {"unit": unit}))
        )
    if found is not None:
        update["joints"] = [
            joint.model_copy(update={"command": _put(joint.command, found), "measured": _put(joint.measured, found)})
            for joint in mapping.joints
        ]
    if mapping.time is not None and mapping.time.unit == UNKNOWN and time is not None and len(time) > 1:
        step = float(np.median(np.abs(np.diff(time))))
        unit = next((name for name, most in _TIME_STEPS if 0.0 < step < most), None)
        if unit is not None:
            update["time"] = mapping.time.model_copy(update={"unit": unit})
    return mapping.model_copy(update=update)


def _put(one: AngleColumn, found: dict[str, Any]) -> AngleColumn:
    return one.model_copy(update=found) if one.unit == UNKNOWN else one


def _angle(columns: Sequence[Array]) -> dict[str, Any] | None:
    """Return unit, counts and offset of columns of one unit, or None where their values do not tell it."""
    values = np.concatenate(columns)
    values = values[np.isfinite(values)]
    if not len(values):
        return None
    most, whole = float(np.abs(values).max()), bool((values == np.round(values)).all())
    if whole and values.min() >= 0.0 and _MORE_THAN < most < _COUNTS:
        return dict(_SAID["counts"])
    if 2.0 * np.pi < most < _MOST_DEGREES and not whole:
        return {"unit": "deg"}
    if most <= 2.0 * np.pi and max(float(np.ptp(one[np.isfinite(one)])) for one in columns) > _LEAST_RAD and not whole:
        return {"unit": "rad"}
    return None
