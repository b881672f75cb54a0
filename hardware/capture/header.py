"""What a capture was made with, to be held against what it is taken up with."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from armtwin.hardware.bench.servo_map import ServoMap
from armtwin.models.errors import RecordingError


def servo_table(servo_map: ServoMap) -> dict[str, Any]:
    """Return the content of `servos.json`: servos count from 1, us_per_rad is negative where one turns against."""
    joints = zip(servo_map.servo.tolist(), servo_map.zero_us.tolist(), servo_map.us_per_rad.tolist(), strict=True)
    return {
        str(number): {"servo": servo + 1, "zero_us": zero_us, "us_per_rad": us_per_rad}
        for number, (servo, zero_us, us_per_rad) in enumerate(joints, start=1)
    }


def read_json(path: Path) -> Any:
    """Return what a file holds; raises `RecordingError` if it is no JSON."""
    try:
        return json.loads(path.read_text("utf-8"))
    except (ValueError, RecursionError) as error:
        raise RecordingError(f"{path}: not JSON ({error}); choose another --out") from None


def first_difference(key: str, found: Any, wanted: Any) -> str:
    """Name the first key at which two tables differ, and both values."""
    if isinstance(found, dict) and isinstance(wanted, dict):
        for name in {**wanted, **found}:
            if found.get(name) != wanted.get(name):
                return first_difference(f"{key}.{name}", found.get(name), wanted.get(name))
    return f"{key}: {str(found)[:60]} there, {str(wanted)[:60]} here"
