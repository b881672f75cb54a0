"""Logs that say little, or of joints that are not what they seem: no wrong name, and a line that says why."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from armtwin.calib.motion.diagnosis import MotionDiagnosis
from armtwin.models.importers.log import JointLog
from armtwin.models.importers.writing import write_import
from armtwin.scenarios.motion.notes import notes
from armtwin.scenarios.motion.pipeline import report_motion
from tests.support.strangers import streams, together, usual

Array = NDArray[np.float64]
TIME, NAMES, SENT, READ = together(streams(usual(1), seconds=5.0))
# Nobody asked a second joint for more than to be there.
STILL = np.zeros((len(TIME), 1))


def diagnosed(folder: Path, sent: Array, read: Array) -> MotionDiagnosis:
    joints = tuple("ab"[: sent.shape[1]])
    write_import(folder / "rec", JointLog(joints, TIME, NAMES, sent, read))
    return report_motion(folder / "rec")


def test_a_joint_whose_reading_is_stuck_is_told_and_named_nothing(tmp_path: Path) -> None:
    found = diagnosed(tmp_path, np.hstack([SENT, SENT]), np.hstack([READ, STILL + 0.1]))
    assert not [cause for cause in found.causes if cause.joint == 2]
    assert any(note.startswith("Joint 2 never moved while commanded to") for note in notes(found))


def test_a_joint_that_is_never_commanded_is_told(tmp_path: Path) -> None:
    found = diagnosed(tmp_path, np.hstack([SENT, STILL]), np.hstack([READ, STILL]))
    assert "Joint 2 got no commands to move: nothing is said of it." in notes(found)


def test_readings_that_have_nothing_to_do_with_the_commands_are_unknown(tmp_path: Path) -> None:
    wander = np.random.default_rng(1).normal(size=SENT.shape)
    found = diagnosed(tmp_path, SENT, wander)
    assert found.verdict == "unknown"
    assert not found.causes


@pytest.mark.parametrize("way", [lambda q: q, lambda q: -q])
def test_of_a_joint_that_never_turns_back_no_friction_is_named(tmp_path: Path, way: Callable[[Array], Array]) -> None:
    ramp = way(np.linspace(-1.0, 1.0, len(TIME))[:, None])
    found = diagnosed(tmp_path, ramp, ramp - 0.01)
    assert not {"friction", "hysteresis", "backlash"} & {cause.effect for cause in found.causes}
    assert any("never turned back" in note for note in notes(found))
