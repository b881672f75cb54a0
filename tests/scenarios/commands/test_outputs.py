"""Folders of results: one writer, nothing stale, nothing left of a failure."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from armtwin.models.errors import InputError
from armtwin.models.folder_lock import only_writer
from armtwin.models.recordings.writer import write_recording
from armtwin.scenarios.cli import main
from armtwin.scenarios.commands.outputs import only_results
from tests.support.recordings import recording


def test_a_folder_in_which_another_works_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_recording(tmp_path / "rec", recording())
    (tmp_path / "out").mkdir()
    for command in ("calibrate", "diagnose"):
        with only_writer(tmp_path / "out"), pytest.raises(SystemExit) as left:
            main([command, str(tmp_path / "rec"), "--out", str(tmp_path / "out")])
        assert left.value.code == 2
        assert "another armtwin is at work there" in capsys.readouterr().err


def test_a_failure_leaves_no_new_folder_and_an_old_one_as_it_was(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no"), only_results(tmp_path / "new"):
        raise InputError("no")
    assert not (tmp_path / "new").exists()
    old = tmp_path / "old"
    old.mkdir()
    (old / "mine.txt").write_text("mine")
    with pytest.raises(InputError, match="no"), only_results(old):
        raise InputError("no")
    assert (old / "mine.txt").read_text() == "mine"


def test_what_a_killed_command_left_aside_is_cleared(tmp_path: Path) -> None:
    code = (
        "import sys, time; from pathlib import Path; from armtwin.scenarios.diagnosis.files import written_together\n"
        "with written_together(Path(sys.argv[1])) as aside:\n"
        "    (aside / 'half.txt').write_text('half'); print('ready', flush=True); time.sleep(60)\n"
    )
    process = subprocess.Popen([sys.executable, "-c", code, str(tmp_path)], stdout=subprocess.PIPE)
    assert process.stdout is not None
    process.stdout.readline()
    process.kill()
    process.wait()
    assert list(tmp_path.glob(".*.part"))
    with only_results(tmp_path):
        assert not list(tmp_path.glob(".*.part"))


def test_an_earlier_advice_goes_where_nothing_is_advised_any_more(tmp_path: Path) -> None:
    write_recording(tmp_path / "rec", recording())
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "next_experiment.csv").write_text("stale")
    with pytest.raises(SystemExit) as left:
        main(["diagnose", str(tmp_path / "rec"), "--out", str(tmp_path / "out")])
    assert left.value.code == 0
    assert not (tmp_path / "out" / "next_experiment.csv").exists()
