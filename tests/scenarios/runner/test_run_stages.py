"""The engine: stages in the order of their needs, none done twice, and the truth about one that fails."""

import os
import signal
from pathlib import Path
from typing import Any

import pytest

from armtwin.models.errors import InputError, JobError
from armtwin.scenarios.runner.job import Job, open_job
from armtwin.scenarios.runner.run import run_stages
from armtwin.scenarios.runner.stage import Stage, Tick
from armtwin.scenarios.scenario import read_scenario


def note(job: Job, tick: Tick) -> dict[str, Any]:
    """Write down which stages were done before."""
    tick(1, 1)
    return {"after": sorted(path.stem for path in (job.out / "stages").glob("*.json"))}


def refuse(job: Job, tick: Tick) -> dict[str, Any]:
    raise InputError("this.toml: key 'a' is wrong")


def die(job: Job, tick: Tick) -> dict[str, Any]:
    os.kill(os.getpid(), signal.SIGKILL)
    return {}


@pytest.fixture
def job(tmp_path: Path) -> Job:
    return open_job(tmp_path / "out", read_scenario("geometric"))


def test_a_stage_is_done_after_all_that_it_needs(job: Job) -> None:
    stages = {
        "last": Stage("Last", ("left", "right"), note),
        "left": Stage("Left", ("first",), note),
        "right": Stage("Right", ("first",), note),
        "first": Stage("First", (), note),
    }
    run_stages(job, stages, quiet=True)
    assert job.load("first")["after"] == []
    assert job.load("last")["after"] == ["first", "left", "right"]


def test_what_is_done_is_not_done_again(job: Job) -> None:
    stages = {"first": Stage("First", (), note), "second": Stage("Second", ("first",), note)}
    run_stages(job, {"first": stages["first"]}, 1, quiet=True)
    before = job.stage_path("first").stat().st_mtime_ns
    run_stages(job, stages, 1, quiet=True)
    assert job.stage_path("first").stat().st_mtime_ns == before
    run_stages(job, stages, 1, quiet=True)


def test_what_a_stage_refuses_is_said_as_it_said_it(job: Job) -> None:
    with pytest.raises(InputError, match=r"^this\.toml: key 'a' is wrong$"):
        run_stages(job, {"only": Stage("Only", (), refuse)}, quiet=True)
    assert not job.done("only")


def test_a_killed_worker_is_named_by_its_stage(job: Job) -> None:
    with pytest.raises(JobError, match="the process that did stage 'only' was ended; run the same command again"):
        run_stages(job, {"only": Stage("Only", (), die)}, quiet=True)


def test_stages_that_wait_for_one_another_are_named(job: Job) -> None:
    circle = {"a": Stage("A", ("b",), note), "b": Stage("B", ("a",), note)}
    with pytest.raises(JobError, match=r"no stage can go on: [ab], [ab] wait for one another"):
        run_stages(job, circle, quiet=True)
