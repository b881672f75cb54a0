"""What `armtwin diagnose` says of one sealed log, read from its `diagnosis.json` and kept."""

from __future__ import annotations

import hashlib
import json
import resource
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import armtwin
from armtwin.models import atomic
from armtwin.models.errors import JobError
from armtwin.scenarios.scoring.sealing import world_folder

# A log of 6 joints and 6,000 rows takes a minute; what takes an hour hangs.
_LONGEST_S = 3600.0
_ROOMS = ("calib", "models", "scenarios")


@dataclass(frozen=True)
class LogTask:
    """Log `index` of the set in `out`, to be diagnosed by code of this `version`."""

    out: Path
    index: int
    version: str

    @property
    def kept_at(self) -> Path:
        """Where its outcome is kept."""
        return self.out / "score" / f"{self.index:04d}.json"


def moving_version() -> str:
    """Return a digest of the code that diagnoses: results of other code are not to be counted."""
    digest = hashlib.sha256()
    root = Path(armtwin.__file__).parent
    for room in _ROOMS:
        for path in sorted((root / room).resolve().rglob("*.py")):
            if "scoring" not in path.parts:
                digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def kept_log_outcome(task: LogTask) -> dict[str, Any] | None:
    """Return the outcome of an earlier run of the same code on the same log, or None."""
    try:
        kept: Any = json.loads(task.kept_at.read_text("utf-8"))
    except (OSError, ValueError, RecursionError):
        return None
    same = isinstance(kept, dict) and kept.get("version") == task.version and kept.get("log") == _digest(task)
    return kept if same else None


def diagnose_log(task: LogTask) -> dict[str, Any]:
    """Diagnose a log as a person would, keep the outcome on disk and return it; raises `JobError`."""
    folder = world_folder(task.out, task.index)
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    with tempfile.TemporaryDirectory() as at:
        command = [sys.executable, "-m", "armtwin", "diagnose", str(folder), "--out", str(Path(at) / "said")]
        try:
            ran = subprocess.run(  # noqa: S603 (this very program)
                command, capture_output=True, text=True, timeout=_LONGEST_S, check=False
            )
        except subprocess.TimeoutExpired:
            raise JobError(f"{folder}: armtwin diagnose took more than {_LONGEST_S:.0f} s") from None
        if ran.returncode:
            last = (ran.stderr.strip() or "it said nothing").splitlines()[-1]
            raise JobError(f"{folder}: armtwin diagnose ended with {ran.returncode}: {last}")
        said: dict[str, Any] = json.loads((Path(at) / "said" / "diagnosis.json").read_text("utf-8"))
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    outcome = {"version": task.version, "log": _digest(task), "seconds": seconds, **outcome_of_table(said)}
    atomic.write_json(task.kept_at, outcome)
    return outcome


def outcome_of_table(said: Mapping[str, Any]) -> dict[str, Any]:
    """Return what is judged of a `diagnosis.json`: verdict, causes with their numbers, and held-out errors."""
    return {
        "verdict": said["verdict"],
        "causes": [_cause(cause) for cause in said["causes"]],
        "held_out": said["held_out"].get("joints", []),
        "unexplained": said.get("unexplained"),
    }


def _cause(cause: Mapping[str, Any]) -> dict[str, Any]:
    known = {
        name: dict(number)
        for name, number in cause.get("parameters", {}).items()
        if isinstance(number, Mapping) and _is_number(number.get("value")) and _is_number(number.get("std"))
    }
    others = [_place(one) for one in cause.get("equivalents", [])]
    return {**_place(cause), "parameters": known, "equivalents": others, "explained": cause.get("explained_percent")}


def _place(cause: Mapping[str, Any]) -> dict[str, Any]:
    return {"effect": cause["effect"], "joint": cause.get("joint"), "marker": cause.get("marker")}


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _digest(task: LogTask) -> str:
    return hashlib.sha256((world_folder(task.out, task.index) / "samples.csv").read_bytes()).hexdigest()[:16]
