"""`import armtwin`: names that stay, found when they are used, and typed."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import armtwin
from armtwin.models.recordings.writer import write_recording
from tests.support.recordings import recording


def test_every_name_is_there_and_documented() -> None:
    for name in armtwin.__all__:
        assert (getattr(armtwin, name).__doc__ or "").strip(), name
    assert set(armtwin.__all__) <= set(dir(armtwin))


def test_importing_it_imports_nothing_else() -> None:
    code = (
        "import sys, armtwin; print([name for name in sys.modules if name.startswith(('armtwin.', 'numpy', 'mujoco'))])"
    )
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True).stdout == "[]\n"


def test_a_name_that_is_not_there_is_told_with_those_that_are() -> None:
    with pytest.raises(AttributeError, match=r"has no attribute 'diagnoze'; it offers .*diagnose"):
        armtwin.diagnoze  # type: ignore[attr-defined]  # noqa: B018


def test_a_recording_is_read_calibrated_and_diagnosed(tmp_path: Path) -> None:
    write_recording(tmp_path / "first", recording())
    read = armtwin.read_recording(str(tmp_path / "first"))
    found = armtwin.calibrate(read)
    assert np.isfinite(found.deviation.lengths_mm).all()
    assert armtwin.calibrate(read, ["wave_0", "wave_1"], method="algorithm-1").method != found.method
    assert armtwin.diagnose(read).verdict == "none"


def test_the_example_of_the_module_runs_as_it_stands(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_recording(tmp_path / "recordings" / "first", recording())
    (tmp_path / "path.csv").write_text("x_mm,y_mm\n-150,40\n-140,45\n")
    monkeypatch.chdir(tmp_path)
    lines = [line[4:] for line in (armtwin.__doc__ or "").splitlines() if not line or line.startswith("    ")]
    names: dict[str, object] = {"q_cmd_rad": np.array([0.1, 0.0, -0.1])}
    exec("\n".join(lines), names)
    assert getattr(names["found"], "verdict") == "none"  # noqa: B009
    assert (tmp_path / "arm.xml").is_file()
    assert names["frame"].image.shape == (720, 1280, 3)  # type: ignore[attr-defined]


def test_a_camera_is_calibrated_from_photographs_or_says_why_not(tmp_path: Path) -> None:
    with pytest.raises(armtwin.InputError):
        armtwin.calibrate_camera([tmp_path])


def test_a_mistake_is_one_of_its_errors(tmp_path: Path) -> None:
    with pytest.raises(armtwin.RecordingError, match="no such folder"):
        armtwin.read_recording(tmp_path / "nowhere")
    with pytest.raises(armtwin.InputError, match="is no bench"):
        armtwin.open_bench("nowhere")
    with pytest.raises(armtwin.InputError, match="no such scenario"):
        armtwin.run("nowhere", tmp_path / "out")


@pytest.mark.slow
def test_a_type_checker_knows_the_names_and_refuses_others(tmp_path: Path) -> None:
    script = tmp_path / "script.py"
    script.write_text("import armtwin\nreveal_type(armtwin.diagnose(armtwin.read_recording('x')))\narmtwin.diagnoze\n")
    command = [sys.executable, "-m", "mypy", "--no-incremental", "--follow-imports=silent", str(script)]
    said = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True).stdout
    both = "armtwin.calib.diagnosis.diagnosis.Diagnosis | armtwin.calib.motion.diagnosis.MotionDiagnosis"
    assert f'Revealed type is "{both}"' in said
    assert 'script.py:3: error: Module has no attribute "diagnoze"' in said
    assert "Found 1 error in 1 file" in said
