"""A run's folder: the scenario it belongs to, and what each stage wrote."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from armtwin.models import atomic
from armtwin.models.errors import InputError
from armtwin.models.folder_lock import only_writer
from armtwin.scenarios.scenario import ScenarioFile, check_scenario

# What the stages' files mean; a change of what any stage writes counts it up, and older results are made again.
FORMAT = 1
_FORMAT_KEY = "format"


@dataclass(frozen=True)
class Job:
    """A run in folder `out`: `scenario.json`, `stages/`, `recordings/`, and at the end its results."""

    out: Path

    @cached_property
    def scenario(self) -> ScenarioFile:
        """The scenario, as it was when the run was started."""
        path = self._scenario_path
        try:
            data = json.loads(path.read_text("utf-8"))
        except (ValueError, RecursionError) as error:
            raise InputError(f"{path}: not JSON ({error}), so no run can go on; choose another --out") from None
        return check_scenario(data, str(path))

    @property
    def recordings(self) -> Path:
        """Folder of the captured recordings."""
        return self.out / "recordings"

    @property
    def _scenario_path(self) -> Path:
        return self.out / "scenario.json"

    def stage_path(self, stage: str) -> Path:
        """Return where a stage's result is; the file stands there when the stage is done."""
        return self.out / "stages" / f"{stage}.json"

    def done(self, stage: str, writes: Sequence[str] = ()) -> bool:
        """Whether a stage was finished by this version, and its file and what it `writes` in the folder still stand."""
        return self._kept(stage) is not None and all((self.out / name).exists() for name in writes)

    def save(self, stage: str, value: dict[str, Any]) -> None:
        """Write what a stage found."""
        atomic.write_json(self.stage_path(stage), {_FORMAT_KEY: FORMAT, **value})

    def load(self, stage: str) -> dict[str, Any]:
        """Return what a finished stage wrote; raises `InputError` where its file is broken or older."""
        value = self._kept(stage)
        if value is None:
            raise InputError(f"{self.stage_path(stage)}: no stage that this version finished; run the scenario again")
        return value

    def _kept(self, stage: str) -> dict[str, Any] | None:
        """Return a stage's result, or None where there is none, it was cut off, or an older version wrote it."""
        path = self.stage_path(stage)
        if not path.is_file():
            return None
        try:
            value = json.loads(path.read_text("utf-8"))
        except (ValueError, RecursionError):
            return None
        return value if isinstance(value, dict) and value.pop(_FORMAT_KEY, None) == FORMAT else None


def open_job(out: Path, scenario: ScenarioFile) -> Job:
    """Start a run in `out`, or go on with the one that is there; raises `InputError` where another one is there."""
    job = Job(out)
    path = job.out / "scenario.json"
    if path.is_file():
        if job.scenario.fingerprint != scenario.fingerprint:
            raise InputError(
                f"{out}: holds a run of another scenario ('{job.scenario.title}', or an edited one); "
                "choose another --out or remove the folder"
            )
    elif out.exists() and (not out.is_dir() or set(out.iterdir()) - set(atomic.leftovers(out))):
        raise InputError(f"{out}: is no run's folder and not empty; choose another --out")
    else:
        atomic.write_json(path, scenario.model_dump(mode="json", by_alias=True))
    return job


@contextmanager
def locked(job: Job) -> Iterator[None]:
    """Hold the run's folder, and clear what a killed run, or this one's ended workers, left half written in it.

    Raises `InputError` where another process is at work there.
    """
    with only_writer(job.out):
        atomic.clear_leftovers(job.out)
        try:
            yield
        finally:
            atomic.clear_leftovers(job.out)
