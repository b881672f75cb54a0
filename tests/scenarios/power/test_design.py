from dataclasses import replace

import numpy as np
import pytest

from armtwin.calib.arm.observability import observability
from armtwin.models.arm import nominal_arm
from armtwin.models.catalogue.predict import Active
from armtwin.models.catalogue.registry import effect_named
from armtwin.models.catalogue.site import Site
from armtwin.models.plan import MAX_STEP_RAD, paper_plan
from armtwin.scenarios.power.design import design
from armtwin.scenarios.power.ground import Fault, Ground
from armtwin.scenarios.power.setting import Setting
from armtwin.sim.sealed.plans import joint_ranges

_PLAN = paper_plan(nominal_arm())
_SETTING = Setting(_PLAN, 0.1, ("a", "b", "c", "f"))
_RANGES = joint_ranges(nominal_arm())


def _gain(joint: int) -> Fault:
    return Fault(f"gain {joint}", Active(effect_named("servo_gain"), Site(joint), np.array([1.01])))


@pytest.fixture(scope="module")
def ground() -> Ground:
    return Ground(_SETTING, [_gain(1), _gain(2), _gain(3)], goal=_PLAN.q_cmd[::10])


def test_half_the_poses_show_a_gain_better_where_they_are_chosen_for_it(ground: Ground) -> None:
    proposed = design(ground, _PLAN, 75, _RANGES, moves=150)
    assert len(proposed.plan) == 75
    assert min(proposed.ratios.values()) > 1.0
    assert np.abs(np.diff(proposed.plan.q_cmd, axis=0)).max() <= MAX_STEP_RAD + 1e-9
    assert ground.is_seen(proposed.plan.q_cmd).all()
    assert (proposed.plan.q_cmd >= _RANGES[:, 0] - 1e-12).all()
    assert (proposed.plan.q_cmd <= _RANGES[:, 1] + 1e-12).all()


def test_poses_that_are_added_leave_those_of_the_plan_in_place(ground: Ground) -> None:
    proposed = design(ground, _PLAN, 20, _RANGES, add=True, moves=20)
    np.testing.assert_array_equal(proposed.plan.q_cmd[: len(_PLAN)], _PLAN.q_cmd)
    assert len(proposed.plan) == len(_PLAN) + 20
    assert min(proposed.ratios.values()) > 1.0
    assert proposed.path_after_mm is not None
    assert proposed.path_before_mm is not None
    assert proposed.path_after_mm < proposed.path_before_mm


def test_a_goal_alone_asks_for_poses_that_make_its_error_small() -> None:
    ground = Ground(_SETTING, (), goal=_PLAN.q_cmd[100:])
    few = design(ground, _PLAN, 40, _RANGES, moves=1)
    many = design(ground, _PLAN, 40, _RANGES, moves=300)
    assert few.path_after_mm is not None
    assert many.path_after_mm is not None
    assert many.path_after_mm < 0.99 * few.path_after_mm


def test_what_a_rival_takes_up_does_not_count_for_the_pair() -> None:
    gain = _gain(1)
    twin = Active(effect_named("servo_gain"), Site(1), np.array([1.02]))
    alone, beside = Ground(_SETTING, [gain]), Ground(_SETTING, [replace(gain, rivals=(twin,))])
    assert beside.worth(_PLAN.q_cmd)[0] == pytest.approx(alone.worth(_PLAN.q_cmd)[0])
    assert beside.worth(_PLAN.q_cmd)[1] < 1e-3 * beside.worth(_PLAN.q_cmd)[0]


def test_indices_are_those_of_the_singular_values() -> None:
    J = np.diag([4.0, 2.0, 1.0])
    one = observability(J, 4)
    assert one.o1 == pytest.approx(1.0)
    assert (one.o2, one.o3, one.o4) == pytest.approx((0.25, 1.0, 0.25))
    assert one.o5 == pytest.approx(1.0 / 1.75)
    assert observability(np.ones((5, 2)), 5).o3 == 0.0
