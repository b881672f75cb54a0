"""What a capture was made with, to be held against what it is taken up with."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from armtwin.models import atomic
from armtwin.models.bench import BenchDescription
from armtwin.models.errors import InputError, RecordingError


def write_bench_record(path: Path, bench: BenchDescription, clock_origin_s: float | None) -> None:
    """Keep what commands become on the bench, and the Unix time that its clock counts from; atomically."""
    atomic.write_json(path, {"actuation": dict(bench.actuation), "clock_origin_s": clock_origin_s})


def note_hold_out(path: Path, hold_out: tuple[str, ...]) -> None:
    """Keep which trajectories are to be held out when all poses are there."""
    atomic.write_json(path, {**_record(path), "hold_out": list(hold_out)})


def agreed_hold_out(path: Path, asked: tuple[str, ...] | None) -> tuple[str, ...] | None:
    """Return what is to be held out: what was asked for so far, where nothing is asked now; None: nothing ever was.

    Raises `InputError` where another is asked for than the capture began with.
    """
    found = _record(path).get("hold_out")
    began = tuple(map(str, found)) if isinstance(found, list) else None
    if began is not None and asked not in (None, began):
        raise InputError(
            f"--hold-out: {', '.join(asked or ()) or 'nothing'} is asked for, the capture in {path.parent} began with "
            f"{', '.join(began) or 'nothing'}; leave it out, or choose another --out"
        )
    return began if asked is None else asked


def refuse_other_actuation(path: Path, bench: BenchDescription) -> None:
    """Raise `RecordingError` where what was captured so far was actuated in another way."""
    wanted = json.loads(json.dumps(dict(bench.actuation)))
    found = _record(path).get("actuation", wanted)  # a recording that was not captured here has none
    if found != wanted:
        raise RecordingError(
            f"{path}: the poses here were captured with another servo map or on another bench "
            f"({first_difference('actuation', found, wanted)}); choose another --out, or set the bench back"
        )


def clocks_apart_s(path: Path, clock_origin_s: float | None, last_s: float) -> float:
    """Return what to add to a frame's time so that a recording's, which ends at `last_s`, goes on and never back."""
    first = _record(path).get("clock_origin_s")
    if clock_origin_s is None or not isinstance(first, float):
        return last_s
    return max(clock_origin_s - first, last_s)


def _record(path: Path) -> dict[str, Any]:
    found = read_json(path) if path.exists() else {}
    if not isinstance(found, dict):
        raise RecordingError(f"{path}: a table in braces is wanted; choose another --out")
    return found


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
