"""Several files appear together, or none of them does."""

from pathlib import Path

import pytest

from armtwin.scenarios.diagnosis.files import written_together


def test_files_take_their_places_when_all_are_written(tmp_path: Path) -> None:
    out = tmp_path / "new" / "out"
    with written_together(out) as aside:
        (aside / "a.txt").write_text("a")
        (aside / "b.txt").write_text("b")
        assert [path.name for path in out.iterdir() if path.suffix == ".txt"] == []
    assert sorted(path.name for path in out.iterdir()) == ["a.txt", "b.txt"]


def test_a_failure_leaves_everything_as_it_was(tmp_path: Path) -> None:
    (tmp_path / "a.txt").write_text("old")

    def half_written() -> None:
        with written_together(tmp_path) as aside:
            (aside / "a.txt").write_text("new")
            raise RuntimeError("the second file could not be made")

    with pytest.raises(RuntimeError):
        half_written()
    assert [(path.name, path.read_text()) for path in tmp_path.iterdir()] == [("a.txt", "old")]


def test_what_else_the_folder_holds_stays(tmp_path: Path) -> None:
    (tmp_path / "mine.txt").write_text("mine")
    with written_together(tmp_path) as aside:
        (aside / "a.txt").write_text("a")
    assert (tmp_path / "mine.txt").read_text() == "mine"
