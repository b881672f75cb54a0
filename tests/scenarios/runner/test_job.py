"""A run's folder."""

from pathlib import Path

import pytest

from models.errors import InputError
from scenarios.runner.job import open_job
from scenarios.scenario import read_scenario


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
