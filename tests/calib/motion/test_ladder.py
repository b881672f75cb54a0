"""Of an arm all of whose joints rub it is said how, by what predicts motions that were not fitted."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from armtwin.calib.motion.diagnosis import MotionDiagnosis
from armtwin.calib.motion.obstructed import obstructed
from armtwin.calib.motion.problem import motion_problem
from armtwin.models.recordings.moving_reader import read_moving
from tests.calib.motion.test_diagnosis import diagnosed
from tests.support.moving import Faults, write_log

DRY_RAD = 0.02
ALL_RUB = Faults({joint: {"delay": 0.03, "tau": 0.06, "friction": DRY_RAD} for joint in range(3)})


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory) -> MotionDiagnosis:
    return diagnosed(tmp_path_factory.mktemp("rubbing"), 4, ALL_RUB)


def test_friction_is_named_at_every_joint_that_rubs_and_no_play(found: MotionDiagnosis) -> None:
    for joint in (1, 2, 3):
        effects = {cause.effect for cause in found.causes if cause.joint == joint}
        assert "friction" in effects
        assert "servo_lag" in effects
        assert not effects & {"backlash", "hysteresis", "dead_band", "contact"}


def test_an_arm_that_rubs_is_followed_through_motions_that_were_not_fitted(found: MotionDiagnosis) -> None:
    assert max(one.after_rms_rad for one in found.held_out) < 2e-3
    assert min(one.before_rms_rad for one in found.held_out) > 1e-2


def test_a_stretch_in_which_the_arm_waits_short_of_its_command_is_told_with_its_rows(tmp_path: Path) -> None:
    whole = motion_problem(read_moving(write_log(tmp_path / "log", 4, Faults()))).series[0]
    sent = 0.5 * np.sin(0.9 * whole.time_s)
    series = replace(whole, sent=sent, measured=np.minimum(sent, 0.47))
    e = sent - series.measured + 5e-4 * np.random.default_rng(1).normal(size=len(sent))
    in_the_way = np.flatnonzero(series.used & (sent > 0.49))
    rows = obstructed(series, e)
    at_an_end = 20  # a motion begins or ends within one of the stretches
    assert len(np.setdiff1d(in_the_way, rows)) <= at_an_end
    assert series.measured[rows].min() > 0.45


def test_a_swing_that_the_twin_follows_late_is_in_nobodys_way(tmp_path: Path) -> None:
    whole = motion_problem(read_moving(write_log(tmp_path / "log", 4, Faults()))).series[0]
    sent = 0.3 * np.sin(12.0 * whole.time_s)
    series = replace(whole, sent=sent, measured=0.3 * np.sin(12.0 * (whole.time_s - 0.05)))
    assert len(obstructed(series, np.where(whole.time_s > 20.0, sent - series.measured, 0.0))) == 0
