"""`armtwin diagnose`: a recording in, the cause, the gain and the extended twin out; or one line that says why not."""

from __future__ import annotations

import contextlib
import csv
import io
import json
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from armtwin.models.arm import Arm
from armtwin.models.kinematics import Deviation
from armtwin.models.recordings.reader import read_recording
from armtwin.models.recordings.recording import Recording, make_samples
from armtwin.models.recordings.writer import write_recording
from armtwin.models.twin import read_twin, rebuild
from armtwin.scenarios.cli import main
from armtwin.scenarios.diagnosis.resimulate import resimulate
from armtwin.sim.observe import make_recording
from tests.support.worlds import flat_world, with_effect

NOISE_PX = 0.08
WIDTH_RAD = 0.015
BUILT = Deviation(np.array([2.0, -3.0, 0.5, 0.1]), np.array([0.02, -0.03, 0.01]))
Rows = list[list[str]]
DATA = Path(__file__).parents[4] / "shared" / "data" / "brachiograph"


def commands(n: int = 96) -> np.ndarray:
    """(n, 3) commands that reverse often."""
    steps = np.linspace(0.0, 8.0 * np.pi, n)
    return 0.3 * np.stack([np.sin(steps), np.sin(0.7 * steps + 1.0), np.cos(0.9 * steps)], axis=-1)


def names(n: int = 96) -> np.ndarray:
    return np.repeat(["one", "two", "three", "four"], n // 4)


@pytest.fixture(scope="module")
def played(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a recording made in MuJoCo with play at joint 2."""
    folder = tmp_path_factory.mktemp("recordings") / "played"
    world = with_effect(flat_world(BUILT), "backlash", {"width_rad": WIDTH_RAD}, joint=2)
    rng = np.random.default_rng(11)
    write_recording(folder, make_recording(world, commands(), names(), None, rng, NOISE_PX, held_out=("four",)))
    return folder


@pytest.fixture(scope="module")
def diagnosed(played: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    """Return the folder and the printed summary of the diagnosis."""
    out = tmp_path_factory.mktemp("out")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("COLUMNS", "200")
        printed = _printed(["diagnose", str(played), "--out", str(out)])
    return out, printed


def _printed(arguments: list[str]) -> str:
    said = io.StringIO()
    with contextlib.redirect_stdout(said), pytest.raises(SystemExit) as left:
        main(arguments)
    assert left.value.code == 0
    return said.getvalue()


def table(diagnosed: tuple[Path, str]) -> dict[str, Any]:
    content: dict[str, Any] = json.loads((diagnosed[0] / "diagnosis.json").read_text())
    return content


def test_it_names_the_cause_its_joint_and_its_parameters(diagnosed: tuple[Path, str]) -> None:
    found = table(diagnosed)
    assert found["verdict"] == "named"
    (cause,) = found["causes"]
    assert (cause["effect"], cause["joint"], cause["marker"]) == ("backlash", 2, None)
    width = cause["parameters"]["width_rad"]
    assert width["value"] == pytest.approx(WIDTH_RAD, abs=4 * width["std"])
    assert cause["p_value"] < 1e-6
    assert cause["explained_percent"] > 90.0


def test_it_has_every_key_of_the_contract_and_no_other(diagnosed: tuple[Path, str]) -> None:
    found = table(diagnosed)
    assert found["schema"] == "armtwin.diagnosis/1"
    assert set(found) == {*("schema", "verdict", "causes", "geometry", "held_out", "unexplained", "next_experiment")}
    assert set(found["causes"][0]) == {
        *("effect", "joint", "marker", "parameters", "equivalents", "p_value", "explained_percent")
    }
    assert set(found["geometry"]) == {"identifiable", "parameters", "gauge"}
    assert set(found["held_out"]) == {
        *("trajectories", "nominal_rms_mm", "before_rms_mm", "after_rms_mm", "noise_floor_mm"),
        *("gain_percent", "gain_ci95_percent"),
    }
    assert set(found["unexplained"]) == {"rms_mm", "structured", "against"}
    assert all(set(estimate) == {"value", "std"} for estimate in found["geometry"]["parameters"].values())


def test_the_gain_is_measured_on_the_trajectories_that_the_recording_holds_out(diagnosed: tuple[Path, str]) -> None:
    held = table(diagnosed)["held_out"]
    assert held["trajectories"] == ["four"]
    assert held["after_rms_mm"] < 1.15 * held["noise_floor_mm"] < held["before_rms_mm"] < held["nominal_rms_mm"]
    low, high = held["gain_ci95_percent"]
    assert low < held["gain_percent"] < high


def test_the_geometry_s_gauge_is_named(diagnosed: tuple[Path, str]) -> None:
    geometry = table(diagnosed)["geometry"]
    assert geometry["identifiable"] == 6
    assert any(line.startswith("plane_offset") for line in geometry["gauge"])


def test_its_twin_makes_the_recording_again_in_mujoco(diagnosed: tuple[Path, str], played: Path) -> None:
    twin = read_twin(diagnosed[0] / "twin.toml")
    assert [(effect.effect, effect.joint) for effect in twin.effects] == [("backlash", 2)]
    assert rebuild(twin).compile().joint("gap2").range[1] == pytest.approx(WIDTH_RAD / 2, rel=0.05)
    recording = read_recording(played)
    again = resimulate(twin, recording, tuple(recording.markers_px))
    missed = again - np.stack(list(recording.markers_px.values()), axis=1)
    assert np.sqrt(np.mean(missed**2)) < 1.25 * NOISE_PX


def test_its_report_tells_the_story_in_one_file(diagnosed: tuple[Path, str]) -> None:
    page = (diagnosed[0] / "report.html").read_text()
    for chapter in ("What is wrong", "Where the twin is wrong", "What the error follows", "What was considered"):
        assert chapter in page
    assert "direction of approach" in page
    assert "Re-simulated in MuJoCo" in page
    assert "http" not in re.sub(r"<script.*?</script>", "", page, flags=re.DOTALL)
    assert not re.search(r"<script[^>]* src=", page)


def test_its_summary_says_what_was_found_and_what_to_do(diagnosed: tuple[Path, str]) -> None:
    _, said = diagnosed
    assert "The cause is backlash (joint 2)." in said
    assert "width_rad" in said
    assert "95 %" in said
    assert "the noise floor is" in said
    assert "Use twin.toml" in said


def test_nothing_else_in_the_folder_is_touched(played: Path, tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("mine")
    (tmp_path / "twin.toml").write_text("old")
    with pytest.raises(SystemExit) as left:
        main(["diagnose", str(played / "nowhere"), "--out", str(tmp_path)])
    assert left.value.code == 2
    assert sorted(path.name for path in tmp_path.iterdir()) == ["notes.txt", "twin.toml"]
    assert (tmp_path / "twin.toml").read_text() == "old"


def refused(folder: Path, out: Path, capsys: pytest.CaptureFixture[str]) -> str:
    """Return the one line with which a recording is refused."""
    with pytest.raises(SystemExit) as left:
        main(["diagnose", str(folder), "--out", str(out)])
    assert left.value.code == 2
    assert not out.exists()
    said = capsys.readouterr()
    assert said.out == ""
    (line,) = said.err.splitlines()
    return line


@pytest.fixture
def spoiled(played: Path, tmp_path: Path) -> Callable[..., Path]:
    """Return a copy of the recording, its rows and header edited."""

    def spoil(rows: Callable[[Rows], Rows] = lambda rows: rows, **header: object) -> Path:
        folder = tmp_path / "spoiled"
        folder.mkdir()
        with (played / "samples.csv").open(newline="") as stream:
            content = rows(list(csv.reader(stream)))
        with (folder / "samples.csv").open("w", newline="") as stream:
            csv.writer(stream).writerows(content)
        edited = {**json.loads((played / "recording.json").read_text()), **header}
        (folder / "recording.json").write_text(json.dumps({k: v for k, v in edited.items() if v is not None}))
        return folder

    return spoil


def _fill(*columns: str, value: str) -> Callable[[Rows], Rows]:
    def fill(rows: Rows) -> Rows:
        filled = [rows[0]]
        for row in rows[1:]:
            filled.append([value if name in columns else cell for name, cell in zip(rows[0], row, strict=True)])
        return filled

    return fill


def test_too_few_poses_are_refused_with_how_many_are_missing(
    spoiled: Callable[..., Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = spoiled(lambda rows: rows[:4], held_out=None)
    assert "too short to decide: 3 poses, at least 8 are wanted; add 5 poses" in refused(folder, tmp_path / "o", capsys)


def test_of_one_marker_more_poses_are_wanted_than_of_four(
    spoiled: Callable[..., Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    hidden = [f"{name}_{axis}_px" for name in "abc" for axis in "uv"]
    folder = spoiled(lambda rows: _fill(*hidden, value="")(rows[:9]), held_out=None)
    line = refused(folder, tmp_path / "o", capsys)
    assert "too short to decide" in line
    assert "add at least" in line


def test_an_arm_that_never_moves_is_refused(
    spoiled: Callable[..., Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = spoiled(_fill("theta1_cmd_rad", "theta2_cmd_rad", "theta3_cmd_rad", value="0.1"))
    assert "nothing can be told of an arm at rest" in refused(folder, tmp_path / "o", capsys)


def test_a_marker_that_never_moves_with_its_arm_is_refused_by_its_columns(
    spoiled: Callable[..., Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    line = refused(spoiled(_fill("c_u_px", "c_v_px", value="321.5")), tmp_path / "o", capsys)
    assert "samples.csv: c_u_px and c_v_px never change while theta1_cmd_rad does" in line


def test_a_recording_in_which_nothing_was_seen_is_refused(
    spoiled: Callable[..., Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pixels = [f"{name}_{axis}_px" for name in "abcf" for axis in "uv"]
    assert "no marker was seen" in refused(spoiled(_fill(*pixels, value="")), tmp_path / "o", capsys)


def test_times_that_run_backwards_are_refused_by_their_line(
    spoiled: Callable[..., Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    def reverse(rows: Rows) -> Rows:
        return [rows[0], *([row[0], str(-number), *row[2:]] for number, row in enumerate(rows[1:]))]

    line = refused(spoiled(reverse), tmp_path / "o", capsys)
    assert "samples.csv: line 3, column 'time_s': time runs backwards" in line


def test_a_held_out_trajectory_that_does_not_exist_is_refused_with_the_nearest_name(
    spoiled: Callable[..., Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    line = refused(spoiled(held_out=["fuor"]), tmp_path / "o", capsys)
    assert "held_out names trajectory 'fuor'" in line
    assert "did you mean 'four'" in line


def test_a_file_in_the_way_of_the_results_is_named(
    played: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "out").write_text("")
    with pytest.raises(SystemExit) as left:
        main(["diagnose", str(played), "--out", str(tmp_path / "out")])
    assert left.value.code == 2
    assert "is a file, --out wants a folder" in capsys.readouterr().err


def test_an_effect_file_that_defines_none_is_refused(
    played: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "mine.py").write_text("x = 1\n")
    with pytest.raises(SystemExit) as left:
        main(["diagnose", str(played), "--out", str(tmp_path / "o"), "--effects", str(tmp_path / "mine.py")])
    assert left.value.code == 2
    assert "mine.py: defines no EFFECT" in capsys.readouterr().err


def angles(n: int = 24) -> Recording:
    """Return protractor readings of one joint with a gain, and without a camera."""
    rng = np.random.default_rng(3)
    q = np.concatenate([np.linspace(-1.0, 1.0, n // 2), np.linspace(0.95, -1.05, n // 2)])[:, None]
    return Recording(
        arm=Arm("shoulder", np.array([80.0]), np.zeros(2)),
        sample=make_samples(n),
        time_s=np.full(n, np.nan),
        trajectory=np.repeat(["there", "back"], n // 2),
        q_cmd=q,
        q_meas=1.12 * q + 0.2 + 0.003 * rng.standard_normal((n, 1)),
    )


def test_joint_angles_without_a_camera_are_diagnosed_too(tmp_path: Path) -> None:
    write_recording(tmp_path / "angles", angles())
    _printed(["diagnose", str(tmp_path / "angles"), "--out", str(tmp_path / "out")])
    found = json.loads((tmp_path / "out" / "diagnosis.json").read_text())
    assert "servo_gain" in {
        name
        for cause in found["causes"]
        for name in (cause["effect"], *(other["effect"] for other in cause["equivalents"]))
    }
    assert read_twin(tmp_path / "out" / "twin.toml").camera is None


def test_misread_angles_are_no_part_of_the_twin(tmp_path: Path) -> None:
    misread = angles(80)
    assert misread.q_meas is not None
    q_meas = misread.q_meas.copy()
    q_meas[[4, 9]] += 0.5
    write_recording(tmp_path / "angles", replace(misread, q_meas=q_meas))
    _printed(["diagnose", str(tmp_path / "angles"), "--out", str(tmp_path / "out")])
    named = {cause["effect"] for cause in json.loads((tmp_path / "out" / "diagnosis.json").read_text())["causes"]}
    assert "outliers" in named
    assert "outliers" not in {effect.effect for effect in read_twin(tmp_path / "out" / "twin.toml").effects}


def test_poses_from_one_side_only_get_an_answer_and_a_note(tmp_path: Path) -> None:
    one_way = angles(40)
    order = np.argsort(one_way.q_cmd[:, 0])
    q_cmd = one_way.q_cmd[order]
    q_meas = q_cmd * 1.1 + np.random.default_rng(0).normal(0.0, 0.002, q_cmd.shape)
    write_recording(tmp_path / "a", replace(one_way, q_cmd=q_cmd, q_meas=q_meas))
    said = _printed(["diagnose", str(tmp_path / "a"), "--out", str(tmp_path / "out")])
    assert "servo_gain, joint 1" in said
    assert "backlash and hysteresis are one with a joint's zero" in " ".join(said.split())


@pytest.mark.parametrize("name", ["shoulder", "elbow"])
def test_of_real_servos_it_says_that_their_pulses_were_read_coarsely(name: str, tmp_path: Path) -> None:
    if not DATA.is_dir():
        pytest.skip(f"the measurements in {DATA.parent} are not here")
    said = " ".join(_printed(["diagnose", str(DATA / name), "--out", str(tmp_path)]).split())
    assert "different commands lie on steps of 1 deg (0.01745 rad)" in said
    assert "lie on steps of 1 deg" in (tmp_path / "report.html").read_text()
