"""`import armtwin` for moving arms: the examples of its functions run as they stand, results show themselves."""

from __future__ import annotations

import doctest
from pathlib import Path

import mujoco
import numpy as np
import pytest

import armtwin
from armtwin.calib.motion.diagnosis import MotionDiagnosis, diagnose_motion
from armtwin.models.recordings.moving import MovingRecording
from armtwin.models.recordings.moving_writer import write_moving_recording
from armtwin.scenarios import public
from tests.support.moving import Faults, write_log

PLAN = (
    "trajectory,time_s,theta1_cmd_rad,theta2_cmd_rad,theta3_cmd_rad\nthere,0,0,0,0\nthere,0.5,0.2,0,0\nback,2,0,0,0\n"
)


@pytest.fixture(scope="module")
def bench(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, MotionDiagnosis]:
    """Return a folder with the files that the examples name, and what is found in its log."""
    folder = tmp_path_factory.mktemp("public")
    (folder / "logs").mkdir()
    write_log(folder / "logs" / "wave", 21, Faults({1: {"tau": 0.08}}))
    (folder / "plan.csv").write_text(PLAN)
    log = armtwin.read_recording(folder / "logs" / "wave")
    assert isinstance(log, MovingRecording)
    return folder, armtwin.diagnose(log)


@pytest.mark.parametrize("name", ["read_recording", "diagnose", "export_mjcf", "simulate"])
def test_the_examples_run_as_they_stand(
    bench: tuple[Path, MotionDiagnosis], name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder, found = bench
    monkeypatch.chdir(folder)
    monkeypatch.setattr(public, "diagnose_motion", lambda log, tell: found if log.motions else diagnose_motion(log))
    (example,) = doctest.DocTestFinder(recurse=False).find(getattr(armtwin, name), name, globs={"armtwin": armtwin})
    runner = doctest.DocTestRunner()
    said: list[str] = []
    assert runner.run(example, out=said.append).failed == 0, "".join(said)
    assert example.examples


def test_results_show_themselves_and_give_their_columns(bench: tuple[Path, MotionDiagnosis]) -> None:
    pyarrow = pytest.importorskip("pyarrow")
    _, found = bench
    assert pyarrow.table(found.columns()).column("effect").to_pylist() == ["servo_lag"]
    assert "Diagnosis in motion: named" in found._repr_html_()
    assert pyarrow.table(found.recording.columns()).num_rows == len(found.recording)
    assert "2000 rows, 4 motions" in found.recording._repr_html_()
    twin = armtwin.twin_of(found)
    assert pyarrow.table(twin.columns()).column("parameter").to_pylist() == ["time_constant_s"]
    assert "1 causes" in twin._repr_html_()


def test_a_twin_that_was_simulated_is_diagnosed_as_what_it_is(
    bench: tuple[Path, MotionDiagnosis], tmp_path: Path
) -> None:
    _, found = bench
    plan = armtwin.Plan(found.recording.trajectory, found.recording.q_cmd, np.zeros(len(found.recording)))
    log = armtwin.simulate(armtwin.twin_of(found), plan)
    write_moving_recording(tmp_path / "again", log)
    again = armtwin.diagnose(armtwin.read_recording(tmp_path / "again"))
    assert [(cause.effect, cause.joint) for cause in again.causes] == [("servo_lag", 2)]
    lag = again.causes[0].parameters["time_constant_s"].value  # type: ignore[attr-defined]
    assert lag == pytest.approx(0.08, abs=0.004)


def test_its_model_is_loaded_by_plain_mujoco(bench: tuple[Path, MotionDiagnosis], tmp_path: Path) -> None:
    armtwin.export_mjcf(armtwin.twin_of(bench[1]), tmp_path / "arm.xml")
    assert mujoco.MjModel.from_xml_path(str(tmp_path / "arm.xml")).nu == 3


def test_what_only_poses_allow_is_refused_by_name(bench: tuple[Path, MotionDiagnosis], tmp_path: Path) -> None:
    _, found = bench
    twin = armtwin.twin_of(found)
    with pytest.raises(armtwin.InputError, match="poses at rest are wanted"):
        armtwin.calibrate(found.recording)
    with pytest.raises(armtwin.InputError, match="corrected for poses at rest"):
        armtwin.correct(twin, "paper")
    with pytest.raises(armtwin.InputError, match="no URDF holds the drives"):
        armtwin.export_urdf(twin, tmp_path / "arm.urdf")
