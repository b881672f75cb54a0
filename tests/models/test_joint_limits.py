import numpy as np
import pytest

from armtwin.models.arm import Arm
from armtwin.models.errors import InputError
from armtwin.models.joint_limits import JointLimits
from armtwin.models.plan import Plan

LIMITS = JointLimits(np.array([-1.0, -1.0, -1.0]), np.array([1.0, 1.0, 0.5]), 0.3)


def plan_of(rows: list[list[float]]) -> Plan:
    return Plan(np.full(len(rows), "t"), np.array(rows), np.zeros(len(rows)))


def test_a_pose_on_the_limit_is_allowed():
    LIMITS.check_pose(np.array([1.0, -1.0, 0.5]), "pose")


def test_a_pose_beyond_a_limit_names_joint_angle_and_limits():
    with pytest.raises(InputError, match=r"pose: joint 3 at 0.6000 rad \(34.4 deg\) is outside .* -1.0000 to 0.5000"):
        LIMITS.check_pose(np.array([0.0, 0.0, 0.6]), "pose")


def test_an_angle_that_is_no_number_is_refused():
    with pytest.raises(InputError, match="joint 2"):
        LIMITS.check_pose(np.array([0.0, np.nan, 0.0]), "pose")


def test_a_plan_is_refused_at_the_line_of_its_first_bad_pose():
    with pytest.raises(InputError, match=r"poses.csv: line 4 \(t\): joint 1"):
        LIMITS.check_plan(plan_of([[0.9, 0, 0], [1.0, 0, 0], [1.1, 0, 0], [2.0, 0, 0]]), "poses.csv")


def test_a_plan_with_too_long_a_step_is_refused():
    with pytest.raises(
        InputError, match=r"poses.csv: line 3 .*joint 2 turns 0.4000 rad in one step, 0.3000 is allowed"
    ):
        LIMITS.check_plan(plan_of([[0, 0, 0], [0, 0.4, 0]]), "poses.csv")


def test_a_drawings_limits_and_names_are_those_of_its_joints():
    drawn = np.array([[-1.0, 1.5], [0.0, 2.0]])
    arm = Arm("mine", np.array([100.0, 80.0]), np.zeros(2), joints=("shoulder", "elbow"), joint_limits_rad=drawn)
    limits = JointLimits.of_arm(arm, 1.57)
    limits.check_pose(np.array([1.4, 1.9]), "here")
    with pytest.raises(InputError, match=r"here: joint 2 \(elbow\) at -0.1000 rad .* outside its limits, 0.0000 to 2"):
        limits.check_pose(np.array([0.0, -0.1]), "here")
