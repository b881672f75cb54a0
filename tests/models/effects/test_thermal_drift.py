"""A zero that creeps with time and settles."""

import numpy as np
import pytest

from tests.support.contexts import context_of, one_joint, turned


def drift_of(times: object, constant: float) -> np.ndarray:
    context = context_of(one_joint(1, np.zeros(len(times))), time_s=np.asarray(times, dtype=float))  # type: ignore[arg-type]
    return turned("thermal_drift", context, [0.02, constant], joint=1)[:, 0]


def test_it_starts_at_zero_and_settles_at_the_drift() -> None:
    drift = drift_of([0.0, 10.0, 1e5], 50.0)
    assert drift[0] == 0.0
    assert drift[2] == pytest.approx(0.02)


def test_after_one_time_constant_all_but_one_part_in_e_is_done() -> None:
    assert drift_of([0.0, 50.0], 50.0)[1] == pytest.approx(0.02 * (1.0 - np.exp(-1.0)))


def test_it_never_turns_back() -> None:
    assert (np.diff(drift_of(np.linspace(0.0, 300.0, 40), 60.0)) > 0).all()


def test_where_no_time_was_recorded_a_pose_counts_as_a_second() -> None:
    timed = context_of(one_joint(1, np.zeros(30)), time_s=np.arange(30.0))
    untimed = context_of(one_joint(1, np.zeros(30)), timed=False)
    np.testing.assert_array_equal(*(turned("thermal_drift", c, [0.02, 9.0], joint=1) for c in (timed, untimed)))
