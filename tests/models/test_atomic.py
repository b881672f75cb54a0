import json
import os
import stat
from pathlib import Path

import numpy as np
import pytest

from armtwin.models import atomic
from armtwin.models.atomic import folder_aside, hold


def fill_and_fail(target: Path, failure: BaseException) -> None:
    with atomic.folder_aside(target) as aside:
        (aside / "new").write_text("x")
        raise failure


def test_what_killed_writers_left_aside_is_found_and_cleared_and_nothing_else(tmp_path):
    (tmp_path / "a" / ".frames.xyz.part").mkdir(parents=True)
    (tmp_path / "a" / ".frames.xyz.part" / "0.png").touch()
    (tmp_path / ".x.json.xyz.part").touch()
    (tmp_path / "a" / ".x.xyz.old").mkdir()
    (tmp_path / "kept.part").touch()

    assert len(atomic.leftovers(tmp_path)) == 3
    atomic.clear_leftovers(tmp_path)

    assert sorted(path.name for path in tmp_path.rglob("*")) == ["a", "kept.part"]


def test_text_is_written_whole_with_its_folders(tmp_path):
    target = tmp_path / "a" / "b.txt"
    atomic.write_text(target, "Grüße\n")
    assert target.read_text("utf-8") == "Grüße\n"
    assert [p.name for p in target.parent.iterdir()] == ["b.txt"]


def test_an_existing_file_is_replaced(tmp_path):
    target = tmp_path / "x"
    atomic.write_bytes(target, b"old and longer")
    atomic.write_bytes(target, b"new")
    assert target.read_bytes() == b"new"


def test_a_write_that_fails_leaves_the_old_file_and_nothing_beside_it(tmp_path):
    target = tmp_path / "x.json"
    atomic.write_text(target, "old")
    with pytest.raises(TypeError):
        atomic.write_bytes(target, "no bytes")  # the stream refuses it after the file aside was opened
    assert target.read_text() == "old"
    assert [p.name for p in tmp_path.iterdir()] == ["x.json"]


def test_a_folder_in_the_files_place_is_left_as_it_was(tmp_path):
    target = tmp_path / "x"
    target.mkdir()
    (target / "kept").write_text("")
    with pytest.raises(OSError, match="x"):
        atomic.write_text(target, "text")
    assert (target / "kept").exists()
    assert [p.name for p in tmp_path.iterdir()] == ["x"]


def test_json_takes_arrays_and_makes_what_is_not_finite_null(tmp_path):
    path = tmp_path / "x.json"
    value = {
        "array": np.array([[1.5, np.nan], [np.inf, 2.0]]),
        "scalar": np.float64(3.5),
        "count": np.int64(4),
        "flag": np.bool_(True),
        "path": Path("a") / "b",
        "tuple": (1, None, float("nan")),
    }
    atomic.write_json(path, value)
    assert json.loads(path.read_text()) == {
        "array": [[1.5, None], [None, 2.0]],
        "scalar": 3.5,
        "count": 4,
        "flag": True,
        "path": "a/b",
        "tuple": [1, None, None],
    }


def test_json_that_cannot_be_written_leaves_nothing(tmp_path):
    with pytest.raises(TypeError):
        atomic.write_json(tmp_path / "x.json", {"what": object()})
    assert list(tmp_path.iterdir()) == []


def test_the_same_value_gives_the_same_bytes(tmp_path):
    for name in ("a.json", "b.json"):
        atomic.write_json(tmp_path / name, {"z": 0.1 + 0.2, "a": np.arange(3)})
    assert (tmp_path / "a.json").read_bytes() == (tmp_path / "b.json").read_bytes()


def test_a_folder_appears_when_its_block_ends_well(tmp_path):
    target = tmp_path / "out"
    with atomic.folder_aside(target) as aside:
        (aside / "file").write_text("x")
        assert not target.exists()
    assert (target / "file").read_text() == "x"
    assert [p.name for p in tmp_path.iterdir()] == ["out"]


def test_a_folder_whose_block_fails_never_appears(tmp_path):
    target = tmp_path / "out"
    with pytest.raises(RuntimeError, match="stop"):
        fill_and_fail(target, RuntimeError("stop"))
    assert list(tmp_path.iterdir()) == []


def test_a_failing_block_leaves_the_old_folder_untouched(tmp_path):
    target = tmp_path / "out"
    target.mkdir()
    (target / "old").write_text("kept")
    with pytest.raises(KeyboardInterrupt):
        fill_and_fail(target, KeyboardInterrupt())
    assert [p.name for p in target.iterdir()] == ["old"]
    assert [p.name for p in tmp_path.iterdir()] == ["out"]


def test_a_folder_replaces_an_old_one_whole(tmp_path):
    target = tmp_path / "out"
    target.mkdir()
    (target / "old").write_text("")
    with atomic.folder_aside(target) as aside:
        (aside / "new").write_text("")
    assert [p.name for p in target.iterdir()] == ["new"]
    assert [p.name for p in tmp_path.iterdir()] == ["out"]


@pytest.fixture
def flushed(monkeypatch):
    """What is flushed to disk, as (inode, names in the folder then); it is flushed indeed."""
    seen = []
    flush = os.fsync

    def note(handle: int) -> None:
        status = os.fstat(handle)
        names = sorted(os.listdir(handle)) if stat.S_ISDIR(status.st_mode) else []
        seen.append((status.st_ino, names))
        flush(handle)

    monkeypatch.setattr(os, "fsync", note)
    return seen


def test_a_power_cut_after_a_write_takes_back_neither_content_nor_name(tmp_path, flushed):
    atomic.write_text(tmp_path / "x", "text")
    assert flushed == [((tmp_path / "x").stat().st_ino, []), (tmp_path.stat().st_ino, ["x"])]


def test_a_power_cut_after_a_folder_was_replaced_does_not_bring_the_old_one_back(tmp_path, flushed):
    (tmp_path / "out").mkdir()
    with atomic.folder_aside(tmp_path / "out"):
        pass
    ((inode, names),) = flushed
    assert inode == tmp_path.stat().st_ino
    assert "out" in names


def test_what_a_killed_writer_of_a_folder_left_beside_it_goes_and_what_another_holds_stays(tmp_path: Path) -> None:
    left, held = tmp_path / ".target.abc.part", tmp_path / ".target.def.part"
    for folder in (left, held):
        folder.mkdir()
        (folder / "half.txt").write_text("half")
        os.utime(folder, (0, 0))
    handle = hold(held)
    with folder_aside(tmp_path / "target") as aside:
        (aside / "whole.txt").write_text("whole")
    os.close(handle)
    assert sorted(path.name for path in tmp_path.iterdir()) == [".target.def.part", "target"]
