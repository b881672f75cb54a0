"""A run's folder."""

from pathlib import Path

import numpy as np
import pytest

from armtwin.models.errors import InputError
from armtwin.scenarios.runner.frames import read_frame, write_frame
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


@pytest.mark.parametrize("content", ["", "{", '{"value": 1', "[]", '{"value": 1}'], ids=str)
def test_a_stage_whose_file_was_emptied_cut_off_or_written_by_an_older_version_is_not_done(
    tmp_path: Path, content: str
) -> None:
    job = open_job(tmp_path / "out", read_scenario("geometric"))
    job.save("camera", {"value": 1})
    assert job.done("camera")
    assert job.load("camera") == {"value": 1}
    job.stage_path("camera").write_text(content)
    assert not job.done("camera")
    with pytest.raises(InputError, match="run the scenario again"):
        job.load("camera")


def test_a_stage_whose_result_was_deleted_is_not_done(tmp_path: Path) -> None:
    job = open_job(tmp_path / "out", read_scenario("geometric"))
    job.save("report", {})
    (job.out / "report.html").write_text("page")
    assert job.done("report", ("report.html",))
    (job.out / "report.html").unlink()
    assert not job.done("report", ("report.html",))


def test_a_frame_that_was_cut_off_is_one_line(tmp_path: Path) -> None:
    write_frame(tmp_path, 3, np.zeros((8, 8, 3), np.uint8))
    (tmp_path / "000003.png").write_bytes((tmp_path / "000003.png").read_bytes()[:40])
    with pytest.raises(InputError, match=r"000003\.png: no picture that can be read; remove"):
        read_frame(tmp_path, 3)
