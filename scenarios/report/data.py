"""What the sections of a run's report draw on."""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from armtwin.models.recordings.reader import read_recording
from armtwin.models.recordings.recording import Recording


@dataclass(frozen=True)
class RunData:
    """A finished run in a folder: its results, truth, recordings and pictures."""

    out: Path

    @cached_property
    def results(self) -> dict[str, Any]:
        """Content of `results.json`."""
        return self._json("results.json")

    @cached_property
    def truth(self) -> dict[str, Any]:
        """Content of `truth.json`."""
        return self._json("truth.json")

    def stage(self, name: str) -> dict[str, Any]:
        """Return what a stage wrote."""
        return self._json(f"stages/{name}.json")

    def has_stage(self, name: str) -> bool:
        """Whether the run has a stage of that name."""
        return (self.out / "stages" / f"{name}.json").is_file()

    def recording(self, name: str) -> Recording:
        """Return a recording of the run."""
        return read_recording(self.out / "recordings" / name)

    def _json(self, name: str) -> dict[str, Any]:
        value: dict[str, Any] = json.loads((self.out / name).read_text("utf-8"))
        return value
