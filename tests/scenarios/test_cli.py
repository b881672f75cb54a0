"""The command line: exit codes, and one line for whatever a person got wrong."""

import os
import subprocess
import sys
from importlib import metadata
from pathlib import Path

import cv2
import numpy as np
import pytest

from armtwin.models.camera_files import nominal_camera
from armtwin.models.recordings.recording import Recording, make_samples
from armtwin.models.recordings.writer import write_recording
from armtwin.scenarios.cli import COMMANDS, main
from armtwin.scenarios.runner.world import declared_arm
from armtwin.scenarios.scenario import read_scenario


def leave(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> tuple[int, str]:
    """Run the command line; return its exit code and what it said on stderr."""
    with pytest.raises(SystemExit) as left:
        main(arguments)
    code = left.value.code
    return (code if isinstance(code, int) else 0), capsys.readouterr().err


@pytest.fixture
def recording(tmp_path: Path) -> Path:
    """Return a recording of two poses whose frames show nothing."""
    folder = tmp_path / "recording"
    camera = nominal_camera()
    write_recording(
        folder,
        Recording(
            arm=declared_arm(read_scenario("geometric")),
            camera=camera,
            arm_plane_z_mm=-80.87,
            sample=make_samples(2),
            time_s=np.arange(2.0),
            trajectory=np.array(["circle", "circle"]),
            q_cmd=np.zeros((2, 3)),
        ),
    )
    (folder / "frames").mkdir()
    for row in range(2):
        frame = np.full((camera.image_height, camera.image_width, 3), 90, np.uint8)
        cv2.imwrite(str(folder / "frames" / f"{row:06d}.png"), frame)
    return folder


@pytest.mark.parametrize("command", sorted(COMMANDS))
def test_every_command_has_a_help_with_an_example(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as left:
        main([command, "--help"])
    assert left.value.code == 0
    assert f"armtwin {command}" in " ".join(capsys.readouterr().out.split())


def test_the_help_lists_every_command(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as left:
        main(["--help"])
    assert left.value.code == 0
    said = capsys.readouterr().out
    assert [name for name in COMMANDS if name not in said] == []


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["run", "papr", "--out", "out"], "did you mean 'paper'?"),
        (["run", "missing.toml", "--out", "out"], "missing.toml: no such file"),
        (["measure", "nowhere", "--out", "out"], "nowhere: no such folder"),
        (["calibrate", "nowhere", "--out", "out"], "nowhere: no such folder"),
    ],
)
def test_a_wrong_input_is_one_line_and_exit_code_2(
    arguments: list[str],
    said: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    code, error = leave(arguments, capsys)
    assert code == 2
    assert error.startswith("armtwin: ")
    assert said in error
    assert error.count("\n") == 1
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["run"], "Missing argument 'SCENARIO'; see armtwin run --help"),
        (["run", "paper", "--no-such-option"], "--no-such-option"),
        (["rnu"], "No such command 'rnu'"),
        (["measure", "x"], "Missing option '--out'"),
        (["seal", "--n", "-1", "--out", "out"], "'--n'"),
        (["seal", "--seed", str(2**70), "--out", "out"], "'--seed'"),
    ],
)
def test_a_misused_command_is_one_line_and_exit_code_2(
    arguments: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    code, error = leave(arguments, capsys)
    assert code == 2
    assert said in error
    assert error.count("\n") == 1


@pytest.mark.parametrize("out", ["taken/out", "x" * 300], ids=["under-a-file", "too-long"])
@pytest.mark.parametrize("command", ["measure", "calibrate", "diagnose", "seal", "run"])
def test_an_output_where_no_folder_can_be_made_is_refused(
    command: str, out: str, recording: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "taken").write_text("")
    what = {"seal": ["--n", "1"], "run": ["geometric"]}.get(command, [str(recording)])
    code, error = leave([command, *what, "--out", str(tmp_path / out)], capsys)
    assert code == 2
    assert "--out" in error
    assert error.count("\n") == 1


def test_what_would_control_the_terminal_is_not_printed(
    recording: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    samples = recording / "samples.csv"
    samples.write_text(samples.read_text("utf-8").replace("sample,", "\x1b[2J,", 1), "utf-8")
    code, error = leave(["calibrate", str(recording), "--out", str(tmp_path / "out")], capsys)
    assert code == 2
    assert "unknown column" in error
    assert "\x1b" not in error


def test_a_defect_is_one_line_and_exit_code_1(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def break_down(*_: object, **__: object) -> None:
        raise ZeroDivisionError("division by zero")

    monkeypatch.setattr("armtwin.scenarios.commands.measure.read_recording", break_down)
    monkeypatch.delenv("ARMTWIN_TRACEBACK", raising=False)
    code, error = leave(["measure", str(tmp_path), "--out", str(tmp_path / "out")], capsys)
    assert code == 1
    assert "broke down (ZeroDivisionError: division by zero)" in error
    assert error.count("\n") == 1


def test_a_pipe_is_not_read_as_a_recording(recording: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (recording / "samples.csv").unlink()
    os.mkfifo(recording / "samples.csv")
    code, error = leave(["calibrate", str(recording), "--out", str(tmp_path / "out")], capsys)
    assert code == 2
    assert "samples.csv: no plain file" in error


@pytest.mark.parametrize("text", ["", "{", '{"seed": ' + "9" * 5000 + "}"], ids=["empty", "cut", "endless-number"])
def test_a_broken_run_folder_is_refused(text: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "scenario.json").write_text(text)
    code, error = leave(["run", "geometric", "--out", str(tmp_path)], capsys)
    assert code == 2
    assert "scenario.json: not JSON" in error
    assert error.count("\n") == 1


def test_an_effect_that_cannot_be_made_is_named_with_its_file(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = (Path(__file__).parents[2] / "scenarios" / "files" / "geometric.toml").read_text("utf-8")
    (tmp_path / "worn.toml").write_text(text + '\n[[effects]]\nname = "backlash"\njoint = 2\n', "utf-8")
    code, error = leave(["run", str(tmp_path / "worn.toml"), "--out", str(tmp_path / "out")], capsys)
    assert code == 2
    assert "worn.toml: effect 1: key 'width_rad' is missing: a number from 0 to 1 is wanted" in error
    assert not (tmp_path / "out").exists()


def test_a_scenario_with_an_unreachable_path_writes_nothing(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = (Path(__file__).parents[2] / "scenarios" / "files" / "geometric.toml").read_text("utf-8")
    (tmp_path / "far.toml").write_text(text.replace("radius_mm = 25.0", "radius_mm = 500.0"), "utf-8")
    code, error = leave(["run", str(tmp_path / "far.toml"), "--out", str(tmp_path / "out")], capsys)
    assert code == 2
    assert "trajectories.circle_25: pose" in error
    assert "out of reach" in error
    assert not (tmp_path / "out").exists()


def test_frames_without_any_marker_are_refused_with_advice(
    recording: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    code, error = leave(["measure", str(recording), "--out", str(tmp_path / "out")], capsys)
    assert code == 2
    assert "no marker in any of the 2 frames" in error
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("spoil", "said"),
    [
        (lambda path: path.unlink(), "missing"),
        (lambda path: path.write_bytes(path.read_bytes()[:500]), "corrupt"),
        (lambda path: path.write_bytes(b"GIF89a"), "not a PNG"),
        (lambda path: cv2.imwrite(str(path), np.zeros((480, 640, 3), np.uint8)), "640x480"),
    ],
    ids=["missing", "cut", "another-format", "another-size"],
)
def test_a_bad_frame_is_named(
    recording: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], spoil: object, said: str
) -> None:
    assert callable(spoil)
    spoil(recording / "frames" / "000001.png")
    code, error = leave(["measure", str(recording), "--out", str(tmp_path / "out")], capsys)
    assert code == 2
    assert "000001.png" in error
    assert said in error
    assert not (tmp_path / "out").exists()


def test_an_output_that_is_a_file_is_refused(
    recording: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "taken").write_text("")
    code, error = leave(["measure", str(recording), "--out", str(tmp_path / "taken")], capsys)
    assert code == 2
    assert "--out wants a folder" in error


def test_nobody_is_shown_a_traceback(tmp_path: Path) -> None:
    """As a person starts it: a process of its own."""
    (tmp_path / "broken.toml").write_text("seed = 'abc")
    done = subprocess.run(
        [sys.executable, "-c", "from armtwin.scenarios.cli import main; main()", "run", "broken.toml", "--out", "out"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2
    assert done.stderr.startswith("armtwin: broken.toml: not TOML")
    assert "Traceback" not in done.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["broken.toml"]


def test_it_tells_its_version(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as left:
        main(["--version"])
    assert left.value.code == 0
    assert capsys.readouterr().out == f"armtwin {metadata.version('armtwin')}\n"
