"""A zero that creeps with time and settles."""

import numpy as np
import pytest

from armtwin.models.catalogue.registry import Site, effect_named
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


def test_a_winding_and_a_case_creep_at_their_own_pace() -> None:
    context = context_of(one_joint(1, np.zeros(3)), time_s=np.array([0.0, 20.0, 1e4]))
    creep = turned("thermal_drift", context, [0.02, 2.0, 0.05, 400.0, 1.0], joint=1)[:, 0]
    np.testing.assert_allclose(creep[1], 0.02 + 0.05 * (1.0 - np.exp(-0.05)), atol=1e-5)
    np.testing.assert_allclose(creep[2], 0.07, atol=1e-5)


def test_a_zero_follows_the_temperature_that_was_recorded_up_and_down() -> None:
    celsius = np.array([20.0, np.nan, 26.0, 22.0])
    context = context_of(one_joint(1, np.zeros(4)), temperature_c=celsius)
    parameters = effect_named("thermal_drift").parameters(context, Site(joint=1))
    assert [parameter.name for parameter in parameters][-1] == "per_kelvin_rad"
    creep = turned("thermal_drift", context, [0.0, 9.0, 0.0, 9.0, 0.0, 0.01], joint=1)[:, 0]
    np.testing.assert_allclose(creep, [0.0, 0.03, 0.06, 0.02])


def test_a_temperature_that_hardly_changes_is_no_parameter() -> None:
    context = context_of(one_joint(1, np.zeros(3)), temperature_c=np.array([20.0, 20.2, 20.1]))
    assert len(effect_named("thermal_drift").parameters(context, Site(joint=1))) == 5
