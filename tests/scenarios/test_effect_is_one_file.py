"""An effect is one file: dropped anywhere, it is listed, drawn, injected, diagnosed, repaired, reported and scored."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import armtwin
import armtwin.models
from armtwin.calib.diagnosis.diagnosis import diagnose
from armtwin.models.catalogue import registry
from armtwin.models.catalogue.registry import catalogue, effect_named, register_file
from armtwin.scenarios.cli import main
from armtwin.scenarios.runner.job import Job, open_job
from armtwin.scenarios.runner.run import run_stages
from armtwin.scenarios.runner.stage import Stage, Tick
from armtwin.scenarios.scenario import read_scenario
from tests.support.recordings import recording

PAGE = Path(armtwin.models.__file__).parent / "effects" / "README.md"
# A detector that writes the picture's corner where it found nothing: found sample by sample, left out, and counted.
CORNER = '''
"""A detector writes the corner of the picture where it found nothing."""

import numpy as np
from armtwin.models.catalogue.evidence import Sightings
from armtwin.models.catalogue.injection import samples
from armtwin.models.catalogue.registry import Effect, Found, Site, Stage


def find(context, view):
    rows, columns = np.nonzero((view.observed == 0.0).all(axis=-1))
    return [(Site(), np.stack([rows, columns], axis=-1).ravel().astype(float))] if len(rows) else []


def repair(context, seen, site, values):
    counts = seen.counts.copy()
    rows, columns = values.reshape(-1, 2).astype(int).T
    counts[rows, columns] = False
    return Sightings(seen.observed, counts)


def physical(context, values):
    return {"samples": sorted(set(values.reshape(-1, 2)[:, 0].astype(int).tolist()))}


def inject(world, parameters, site):
    def write_corner(pixels, rng):
        out = {name: points.copy() for name, points in pixels.items()}
        out["f"][[row for row in parameters["samples"] if row < len(out["f"])]] = 0.0
        return out

    return world.with_detection(write_corner)


EFFECT = Effect(
    name="corner",
    summary="a detector writes the picture's corner where it found nothing",
    where="arm",
    stage=Stage.OBSERVATION,
    injector=inject,
    injected=(samples("samples"),),
    physical=physical,
    found=Found(find, repair),
    confused_with=("outliers",),
    experiment="the frames in question looked at again",
)
'''


@pytest.fixture(autouse=True)
def _known_effects(monkeypatch: pytest.MonkeyPatch) -> None:
    """Forget afterwards what was added."""
    monkeypatch.setattr(registry, "_LOADED", dict(catalogue()))
    monkeypatch.setattr(registry, "_FILES", {})


@pytest.fixture
def end_stop(tmp_path: Path) -> Path:
    """Return a file with the example of the page on effects."""
    example = re.search(r"```python\n(.*?)```", PAGE.read_text("utf-8"), re.DOTALL)
    assert example is not None
    path = tmp_path / "end_stop.py"
    path.write_text(example[1])
    return path


def _armtwin(*arguments: object) -> None:
    with pytest.raises(SystemExit) as left:
        main([str(argument) for argument in arguments])
    assert left.value.code == 0


@pytest.mark.slow
def test_a_fitted_effect_in_a_file_is_listed_drawn_diagnosed_reported_and_scored(
    end_stop: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    _armtwin("effects", "end_stop", "--effects", end_stop)
    assert "turns no farther" in capsys.readouterr().out

    sealed, found = tmp_path / "sealed", tmp_path / "found"
    _armtwin("seal", "--n", 1, "--seed", 1, "--effects", end_stop, "--out", sealed, "--jobs", 1)
    (hidden,) = json.loads((sealed / "truth.json").read_text())["worlds"]["0000"]["effects"]
    assert hidden["effect"] == "end_stop"

    _armtwin("score", sealed, "--effects", end_stop, "--jobs", 1)  # in a process that was spawned
    (judged,) = json.loads((sealed / "score.json").read_text())["judgements"].values()
    assert judged["right"]
    assert judged["said"] == f"end_stop {hidden['joint']}"

    _armtwin("diagnose", sealed / "worlds" / "0000", "--out", found, "--effects", end_stop)
    (cause,) = json.loads((found / "diagnosis.json").read_text())["causes"]
    assert (cause["effect"], cause["joint"]) == ("end_stop", hidden["joint"])
    assert "end_stop" in (found / "report.html").read_text("utf-8")
    assert 'effect = "end_stop"' in (found / "twin.toml").read_text("utf-8")


@pytest.fixture
def house(end_stop: Path, tmp_path: Path) -> Path:
    """Return a folder with a copy of the package, the effect's file dropped among the others."""
    package = Path(armtwin.__file__).parent
    shutil.copytree(package, tmp_path / "house" / "armtwin", ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(end_stop, tmp_path / "house" / "armtwin" / "models" / "effects")
    return tmp_path / "house"


def _in(house: Path, *arguments: object) -> str:
    """Run the copy's armtwin, and return what it printed."""
    environment = {**os.environ, "PYTHONPATH": str(house), "COLUMNS": "200"}
    command = [sys.executable, "-m", "armtwin", *map(str, arguments)]
    finished = subprocess.run(command, cwd=house, env=environment, capture_output=True, text=True, check=False)
    assert finished.returncode == 0, finished.stderr[-2000:]
    return finished.stdout


def test_a_file_dropped_among_the_effects_is_listed(house: Path) -> None:
    assert "turns no farther" in _in(house, "effects", "end_stop")


@pytest.mark.slow
def test_a_file_dropped_among_the_effects_is_drawn_injected_diagnosed_reported_and_scored(house: Path) -> None:
    _in(house, "seal", "--n", 1, "--seed", 1, "--effects", "end_stop", "--out", "sealed", "--jobs", 1)
    (hidden,) = json.loads((house / "sealed" / "truth.json").read_text())["worlds"]["0000"]["effects"]
    assert hidden["effect"] == "end_stop"

    _in(house, "score", "sealed", "--jobs", 1)
    (judged,) = json.loads((house / "sealed" / "score.json").read_text())["judgements"].values()
    assert judged["said"] == f"end_stop {hidden['joint']}"
    assert judged["right"]

    _in(house, "diagnose", "sealed/worlds/0000", "--out", "found")
    (cause,) = json.loads((house / "found" / "diagnosis.json").read_text())["causes"]
    assert (cause["effect"], cause["joint"]) == ("end_stop", hidden["joint"])
    assert "end_stop" in (house / "found" / "report.html").read_text("utf-8")
    assert 'effect = "end_stop"' in (house / "found" / "twin.toml").read_text("utf-8")


def test_a_found_effect_in_a_file_is_found_and_repaired_before_what_takes_all_that_is_far_off(tmp_path: Path) -> None:
    path = tmp_path / "corner.py"
    path.write_text(CORNER)
    register_file(path)

    def corner(pixels: np.ndarray) -> np.ndarray:
        out = pixels.copy()
        out[[5, 33, 60], 3] = 0.0
        return out

    diagnosis = diagnose(recording(shift_px=corner))
    (cause,) = diagnosis.causes
    assert cause.active.effect.name == "corner"
    assert cause.active.values.reshape(-1, 2)[:, 0].tolist() == [5, 33, 60]
    assert not diagnosis.explanation.data.counts[[5, 33, 60], 3].any()


def _summary(job: Job, tick: Tick) -> dict[str, Any]:
    return {"effect": job.scenario.effects[0].name, "summary": effect_named("end_stop").summary}


def test_a_run_s_workers_know_the_effects_of_the_run(end_stop: Path, tmp_path: Path) -> None:
    register_file(end_stop)
    scenario = tmp_path / "stopped.toml"
    scenario.write_text(
        'schema = "armtwin.scenario/1"\ntitle = "stopped"\n'
        '[[effects]]\nname = "end_stop"\njoint = 2\nlimit_rad = 0.2\n'
        '[trajectories.circle]\nkind = "circle"\nradius_mm = 10.0\nsamples = 8\n'
        '[trajectories.line]\nkind = "line"\nstart_mm = [-145.0, 25.0]\nend_mm = [-115.0, 45.0]\nsamples = 5\n'
    )
    job = open_job(tmp_path / "run", read_scenario(str(scenario)))
    run_stages(job, {"told": Stage("Told", (), _summary)}, 1, quiet=True)
    assert job.load("told") == {"effect": "end_stop", "summary": effect_named("end_stop").summary}
