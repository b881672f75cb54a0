from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from armtwin.models.arm import nominal_arm
from armtwin.models.errors import InputError
from armtwin.models.kinematics import forward
from armtwin.models.plan import Plan, paper_plan, plan_of, read_plan, steps_between, write_plan
from armtwin.models.trajectories import paper_trajectories

GOOD = "trajectory,theta1_cmd_rad,theta2_cmd_rad,payload_kg\nup,0.1,0.2,0.0\nup,0.3,-0.4,0.05\n"


def test_the_papers_plan_runs_its_three_trajectories_through_the_nominal_inverse_kinematics():
    arm = nominal_arm()
    plan = paper_plan(arm)
    assert len(plan) == 150
    for name, poses in paper_trajectories().items():
        tips = forward(arm, plan.q_cmd[plan.trajectory == name])
        np.testing.assert_allclose(tips[:, :2], poses[:, :2], atol=1e-9)
    np.testing.assert_array_equal(plan.payload_kg, 0.0)


def test_blocks_are_run_in_their_order():
    plan = plan_of({"b": np.zeros((2, 1)), "a": np.ones((1, 1))})
    assert plan.trajectory.tolist() == ["b", "b", "a"]
    np.testing.assert_array_equal(plan.q_cmd[:, 0], [0, 0, 1])


@given(arrays(float, (3, 2), elements=st.floats(-6.28, 6.28)), arrays(float, 3, elements=st.floats(0, 1)))
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=50, deadline=None)
def test_a_plan_reads_back_to_the_last_bit(tmp_path, q, payload):
    path = tmp_path / "plan.csv"
    write_plan(path, Plan(np.array(["x", "y, z", "é"]), q, payload))
    again = read_plan(path, 2)
    np.testing.assert_array_equal(again.q_cmd, q)
    np.testing.assert_array_equal(again.payload_kg, payload)
    assert again.trajectory.tolist() == ["x", "y, z", "é"]


def test_the_payload_may_be_left_out(tmp_path):
    path = tmp_path / "plan.csv"
    path.write_text("trajectory,theta1_cmd_rad\nup,0.1\n\n")
    np.testing.assert_array_equal(read_plan(path, 1).payload_kg, [0.0])


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("theta2_cmd_rad", "theta2_cmd", r"column 'theta2_cmd' says no unit; name it theta2_cmd_rad or theta2_cmd_deg"),
        (",theta2_cmd_rad", "", "line 2 has 4 cells, the header has 3"),
        ("theta2_cmd_rad", "theta1_cmd_rad", "column 'theta1_cmd_rad' stands twice"),
        ("0.3", "nan", "line 3, column 'theta1_cmd_rad': 'nan' is no finite number"),
        ("0.3", "", "line 3, column 'theta1_cmd_rad': '' is no finite number"),
        ("-0.4", "-40", "line 3, column 'theta2_cmd_rad': -40 is beyond 2 pi; .*degrees"),
        ("up,0.1,0.2,0.0", "up,0.1,0.2", "line 2 has 3 cells, the header has 4"),
        ("up,0.1,0.2,0.0\nup,0.3,-0.4,0.05\n", "", "no rows"),
    ],
)
def test_a_bad_plan_is_refused_in_one_line(tmp_path, old, new, message):
    path = tmp_path / "plan.csv"
    path.write_text(GOOD.replace(old, new, 1))
    with pytest.raises(InputError, match=message) as error:
        read_plan(path, 2)
    assert str(error.value).startswith("plan.csv: ")
    assert "\n" not in str(error.value)


def test_a_plan_that_does_not_exist_is_named_with_what_one_is(tmp_path):
    with pytest.raises(InputError, match=r"no such file; a plan is a CSV with columns trajectory, theta1_cmd_rad"):
        read_plan(tmp_path / "none.csv", 2)


@pytest.mark.parametrize("content", [b"", b"\xff\xfe\x00"], ids=["empty", "no text"])
def test_a_file_that_is_no_plan_is_refused(tmp_path, content):
    path = tmp_path / "plan.csv"
    path.write_bytes(content)
    with pytest.raises(InputError, match=r"plan\.csv: "):
        read_plan(path, 2)


def test_a_huge_plan_is_refused_before_it_is_read(tmp_path):
    path = tmp_path / "plan.csv"
    with path.open("wb") as stream:
        stream.truncate(1 << 40)  # a sparse terabyte
    with pytest.raises(InputError, match="larger than"):
        read_plan(path, 2)


@pytest.mark.parametrize("payload", ["-0.2", "200"])
def test_a_payload_that_no_servo_of_this_size_holds_is_refused(tmp_path, payload):
    path = tmp_path / "plan.csv"
    path.write_text(f"trajectory,theta1_cmd_rad,payload_kg\nt,0.1,0.0\nt,0.1,{payload}\n")
    with pytest.raises(InputError, match=rf"line 3, column 'payload_kg': {payload} found, 0 to 5 is wanted"):
        read_plan(path, 1)


angles = st.lists(st.floats(-1, 1), min_size=3, max_size=3).map(np.array)


@given(angles, angles)
def test_steps_between_end_at_the_goal_and_none_is_too_long(q_from: np.ndarray, q_to: np.ndarray):
    poses = np.vstack([q_from, steps_between(q_from, q_to, 0.3)])

    np.testing.assert_array_equal(poses[-1], q_to)
    assert np.abs(np.diff(poses, axis=0)).max() <= 0.3 + 1e-9


def test_a_plan_of_an_arm_with_more_joints_is_told_as_that(tmp_path: Path) -> None:
    path = tmp_path / "plan.csv"
    path.write_text("trajectory,theta1_cmd_rad,theta2_cmd_rad,theta3_cmd_rad\na,0,0,0\n")
    with pytest.raises(InputError, match="commands joint 3, and this arm has 2"):
        read_plan(path, 2)
