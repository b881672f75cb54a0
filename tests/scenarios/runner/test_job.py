"""A run's folder."""

from pathlib import Path

import pytest

from armtwin.models.errors import InputError
from armtwin.scenarios.runner.job import locked, open_job
from armtwin.scenarios.scenario import read_scenario


def test_a_folder_with_a_run_of_the_same_scenario_is_gone_on_with(tmp_path: Path) -> None:
    first = open_job(tmp_path / "out", read_scenario("geometric"))
    again = open_job(tmp_path / "out", read_scenario("geometric"))
    assert again.scenario == first.scenario


def test_a_folder_with_another_run_is_refused(tmp_path: Path) -> None:
    open_job(tmp_path / "out", read_scenario("geometric"))
    with pytest.raises(InputError, match="holds a run of another scenario"):
        open_job(tmp_path / "out", read_scenario("noisy"))


def test_a_folder_with_something_else_in_it_is_refused_and_left_alone(tmp_path: Path) -> None:
    (tmp_path / "thesis.tex").write_text("precious")
    with pytest.raises(InputError, match="no run's folder"):
        open_job(tmp_path, read_scenario("geometric"))
    assert [path.name for path in tmp_path.iterdir()] == ["thesis.tex"]


def test_a_file_in_the_place_of_the_folder_is_refused(tmp_path: Path) -> None:
    (tmp_path / "out").write_text("")
    with pytest.raises(InputError, match="choose another --out"):
        open_job(tmp_path / "out", read_scenario("geometric"))


def test_two_runs_in_one_folder_are_refused(tmp_path: Path) -> None:
    job = open_job(tmp_path / "out", read_scenario("geometric"))
    with locked(job), pytest.raises(InputError, match="another armtwin is at work"), locked(job):
        pass


def test_a_run_killed_at_its_first_file_begins_anew(tmp_path: Path) -> None:
    (tmp_path / ".scenario.json.abc.part").write_text("{")
    assert open_job(tmp_path, read_scenario("geometric")).scenario == read_scenario("geometric")


def test_what_a_killed_run_left_half_written_is_cleared(tmp_path: Path) -> None:
    job = open_job(tmp_path / "out", read_scenario("geometric"))
    (job.recordings / "before" / ".frames.abc.part").mkdir(parents=True)
    (job.out / ".results.json.abc.part").write_text("{")
    with locked(job):
        assert not list(job.out.rglob(".*.part"))
