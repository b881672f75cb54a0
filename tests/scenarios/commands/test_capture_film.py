import csv
import json
from pathlib import Path

import numpy as np
import pytest

from armtwin.scenarios.cli import main


def ended(*arguments: str) -> object:
    with pytest.raises(SystemExit) as left:
        main(list(arguments))
    return left.value.code


def plan(folder: Path, *, timed: bool = False, rows: int = 5) -> Path:
    path = folder / "plan.csv"
    q = 0.1 * np.sin(np.arange(rows))
    head = "trajectory,theta1_cmd_rad,theta2_cmd_rad,theta3_cmd_rad" + (",time_s" if timed else "")
    lines = [f"swing,{angle},0,0" + (f",{0.05 * k + 1.0}" if timed else "") for k, angle in enumerate(q)]
    path.write_text("\n".join([head, *lines]) + "\n")
    return path


@pytest.mark.parametrize(("timed", "options", "step"), [(False, ["--rate", "25"], 0.04), (True, [], 0.05)])
def test_a_film_is_a_moving_recording_with_a_picture_and_a_time_a_command(
    tmp_path: Path, timed: bool, options: list[str], step: float
) -> None:
    out = tmp_path / "film"
    file = plan(tmp_path, timed=timed)
    assert ended("capture", "--film", "--bench", "simulated", "--plan", str(file), *options, "--out", str(out)) == 0
    header = json.loads((out / "recording.json").read_text())
    assert header["motion"] == "moving"
    with (out / "samples.csv").open() as rows:
        samples = list(csv.DictReader(rows))
    assert np.diff([float(row["time_s"]) for row in samples]) == pytest.approx(step, abs=1e-5)
    assert len(list((out / "frames").glob("*.png"))) == len(samples) == 5


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--rate", "30"], "--rate: it is that of a film's commands"),
        (["--film", "--speed", "2"], "--speed: 2 found"),
        (["--film", "--hold-out", "none"], "the plan has no trajectory 'none'"),
    ],
)
def test_what_does_not_go_with_a_film_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], options: list[str], message: str
) -> None:
    file, out = str(plan(tmp_path)), str(tmp_path / "out")
    assert ended("capture", "--bench", "simulated", "--plan", file, "--out", out, *options) == 2
    assert message in capsys.readouterr().err
    assert not Path(out).exists()


def test_times_that_run_back_or_are_for_a_film_are_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = plan(tmp_path, timed=True)
    assert ended("capture", "--bench", "simulated", "--plan", str(file), "--out", str(tmp_path / "out")) == 2
    assert "--film keeps" in capsys.readouterr().err
    file.write_text(file.read_text().replace("1.05", "0.5"))
    assert ended("capture", "--film", "--bench", "simulated", "--plan", str(file), "--out", str(tmp_path / "out")) == 2
    assert "is not after 1 s" in capsys.readouterr().err


def test_a_fault_in_time_stands_in_a_scenario_and_is_refused_where_it_cannot_be(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    scenario = tmp_path / "late.toml"
    ideal = Path(__file__).parents[3] / "scenarios" / "files" / "ideal.toml"
    scenario.write_text(ideal.read_text() + '\n[[moving_effects]]\nname = "latncy"\njoint = 1\ndelay_s = 0.05\n')
    file = str(plan(tmp_path))
    assert ended("capture", "--film", "--bench", str(scenario), "--plan", file, "--out", str(tmp_path / "out")) == 2
    assert "did you mean 'latency'" in capsys.readouterr().err
