"""A delay, a lag, a friction is one number over all motions; one that changes from motion to motion is told."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from armtwin.calib.motion.diagnosis import MotionDiagnosis, diagnose_motion
from armtwin.calib.motion.frequency import responses
from armtwin.models.arm import Arm
from armtwin.models.recordings.moving import MovingRecording
from armtwin.models.recordings.moving_reader import read_moving
from armtwin.scenarios.motion.notes import in_every_motion, notes
from tests.support.moving import Faults, write_log

DELAY_S = 0.06
FAULTS = Faults({1: {"delay": DELAY_S}})


@pytest.fixture(scope="module")
def delayed(tmp_path_factory: pytest.TempPathFactory) -> MotionDiagnosis:
    return diagnose_motion(one_joint(write_log(tmp_path_factory.mktemp("delayed") / "log", 5, FAULTS)))


def one_joint(folder: Path, late: tuple[str, float] = ("", 0.0)) -> MovingRecording:
    """Return the delayed joint of a log alone, one of its motions later by so many seconds."""
    log = read_moving(folder)
    seen, rows = log.q_meas[:, 1:2].copy(), log.rows_of(late[0])
    if len(rows):
        seen[rows, 0] = np.interp(log.time_s[rows] - late[1], log.time_s[rows], seen[rows, 0])
    arm = Arm("one", np.full(1, 100.0), np.zeros(2))
    return MovingRecording(arm, log.time_s, log.trajectory, log.q_cmd[:, 1:2], seen, held_out=("stairs",))


def test_a_true_delay_is_the_same_in_every_motion(delayed: MotionDiagnosis) -> None:
    own = [one for one in delayed.by_motion if (one.joint, one.parameter) == (0, "delay_s")]
    assert len(own) >= 2
    assert all(one.value == pytest.approx(DELAY_S, abs=0.004) for one in own)
    assert "the same in every motion" in in_every_motion(delayed)
    assert not any("Not one number" in note for note in notes(delayed))


def test_a_delay_that_changes_from_motion_to_motion_is_told(tmp_path: Path) -> None:
    found = diagnose_motion(one_joint(write_log(tmp_path / "log", 5, FAULTS), ("chirp", 0.04)))
    assert any(one.differs and one.motion == "chirp" for one in found.by_motion)
    assert any(note.startswith("Not one number over all motions") and "chirp" in note for note in notes(found))


def test_the_response_of_a_pure_delay_is_level_and_coherent() -> None:
    rng, n = np.random.default_rng(0), 6000
    time = 0.02 * np.arange(n)
    sent = np.repeat(rng.uniform(-1, 1, n // 10), 10) * np.repeat([0.1, 0.3, 0.9], n // 3)
    seen = np.append(np.zeros(3), sent[:-3])[:, None]
    log = MovingRecording(Arm("one", np.full(1, 100.0), np.zeros(2)), time, np.full(n, "prbs"), sent[:, None], seen)
    found = responses(log, 0, seen[:, 0])
    assert len(found) == 3
    assert np.all(np.diff([one.swing_rad for one in found]) > 0)
    for one in found:
        slow = (one.frequency_hz > 0.4) & (one.frequency_hz < 3.0)
        np.testing.assert_allclose(one.gain[slow], 1.0, atol=0.1)
        np.testing.assert_allclose(one.delay_s[slow], 0.06, atol=0.01)
        assert one.coherence[slow].min() > 0.9


def test_of_a_joint_that_is_not_swung_there_is_no_response() -> None:
    time = 0.02 * np.arange(600)
    still = np.zeros((600, 1))
    log = MovingRecording(Arm("one", np.full(1, 100.0), np.zeros(2)), time, np.full(600, "rest"), still, still)
    assert responses(log, 0, still[:, 0]) == []
