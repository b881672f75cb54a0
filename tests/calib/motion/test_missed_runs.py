"""Commands that a servo missed for a while are found as runs, also where a run begins with a motion."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from armtwin.calib.motion.missed_runs import missed_runs
from armtwin.calib.motion.problem import motion_problem
from armtwin.calib.motion.search import search_joint
from armtwin.models.recordings.moving_reader import read_moving
from tests.support.moving import Faults, write_log

RUNS = ((60, 72), (240, 265))


def test_a_run_of_missed_commands_is_found_with_its_rows(tmp_path: Path) -> None:
    problem = motion_problem(read_moving(write_log(tmp_path / "log", 31, Faults(deaf=(1, RUNS)))))
    model = search_joint(problem, 1, ties=False)
    rows = missed_runs(problem.series[1], model)
    true = np.concatenate([np.arange(*run) for run in RUNS])
    assert len(np.setxor1d(rows, true)) <= 4  # where the command hardly moves a row more or less is the same


def test_where_none_was_missed_no_run_is_found(tmp_path: Path) -> None:
    problem = motion_problem(read_moving(write_log(tmp_path / "log", 32, Faults())))
    assert not len(missed_runs(problem.series[1], search_joint(problem, 1, ties=False)))
