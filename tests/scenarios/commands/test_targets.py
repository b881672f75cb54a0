from pathlib import Path

import pytest

from armtwin.models.errors import InputError
from armtwin.scenarios.cli import main
from armtwin.scenarios.commands.targets import targets_command


def test_writes_a_pdf(tmp_path: Path):
    targets_command(tmp_path / "new" / "targets.pdf", "Letter")

    assert (tmp_path / "new" / "targets.pdf").read_bytes().startswith(b"%PDF-")


def test_a_folder_is_no_pdf(tmp_path: Path):
    with pytest.raises(InputError, match="is a folder"):
        targets_command(tmp_path, "a4")


def test_a_place_that_takes_no_file_is_named_as_it_was_given(capsys: pytest.CaptureFixture[str]):
    with pytest.raises(SystemExit) as left:
        main(["targets", "--out", "/proc/x.pdf"])
    assert left.value.code == 2
    assert capsys.readouterr().err.startswith("armtwin: /proc/x.pdf: ")


def test_unknown_paper_writes_nothing(tmp_path: Path):
    with pytest.raises(InputError, match="valid names are a4, letter"):
        targets_command(tmp_path / "targets.pdf", "a5")
    assert not (tmp_path / "targets.pdf").exists()
