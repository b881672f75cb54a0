from pathlib import Path

import numpy as np
import pytest

from armtwin.models.arm import nominal_arm
from armtwin.models.errors import InputError
from armtwin.models.kinematics import forward
from armtwin.models.plan import Plan, write_plan
from armtwin.models.trajectories import paper_trajectories
from armtwin.scenarios.plans import load_plan


def poses_file(folder: Path, text: str) -> str:
    path = folder / "poses.csv"
    path.write_text(text)
    return str(path)


def test_the_papers_plan_runs_through_its_three_trajectories():
    plan = load_plan("paper", nominal_arm())

    assert list(dict.fromkeys(plan.trajectory)) == ["circle_15", "circle_25", "line"]
    wanted = np.concatenate(list(paper_trajectories().values()))
    np.testing.assert_allclose(forward(nominal_arm(), plan.q_cmd)[:, :2], wanted[:, :2], atol=1e-9)


def test_a_file_of_commands_is_taken_as_it_stands(tmp_path: Path):
    written = Plan(np.array(["a", "b"]), np.array([[0.1, 0.2, 0.3], [0.2, 0.2, 0.3]]), np.array([0.0, 0.05]))
    write_plan(tmp_path / "plan.csv", written)

    plan = load_plan(str(tmp_path / "plan.csv"), nominal_arm())

    np.testing.assert_array_equal(plan.q_cmd, written.q_cmd)
    np.testing.assert_array_equal(plan.payload_kg, written.payload_kg)


def test_poses_of_the_tip_go_through_the_inverse_kinematics(tmp_path: Path):
    name = poses_file(tmp_path, "trajectory,x_mm,y_mm,theta_rad\nt,-130,40,3.0\nt,-120,45,3.1\n")

    plan = load_plan(name, nominal_arm())

    poses = forward(nominal_arm(), plan.q_cmd)
    np.testing.assert_allclose(poses[:, :2], [[-130, 40], [-120, 45]], atol=1e-9)
    np.testing.assert_allclose(np.mod(poses[:, 2], 2 * np.pi), [3.0, 3.1], atol=1e-9)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("trajectory,x_mm,y_mm\nt,1,2\n", "column 'theta_rad' is missing"),
        ("trajectory,x_mm,y_mm,theta_rad\n", "no rows"),
        ("trajectory,x_mm,y_mm,theta_rad\nt,-130,forty,3\n", "line 2, column 'y_mm': 'forty' is no finite number"),
        ("trajectory,x_mm,y_mm,theta_rad\nt,-130,nan,3\n", "line 2, column 'y_mm': 'nan' is no finite number"),
        ("trajectory,x_mm,y_mm,theta_rad\nt,1e300,40,3\n", "line 2, column 'x_mm': '1e+300' is no finite number below"),
        ("trajectory,x_mm,y_mm,theta_rad\nt,-130,40\n", "line 2 has 3 cells"),
        (
            "trajectory,x_mm,y_mm,theta_rad\nt,-130,40,180\n",
            "column 'theta_rad': 180 is beyond 2 pi; angles are in rad",
        ),
    ],
)
def test_bad_files_of_poses_are_refused_in_one_line(tmp_path: Path, text: str, message: str):
    with pytest.raises(InputError) as caught:
        load_plan(poses_file(tmp_path, text), nominal_arm())

    assert message in str(caught.value)
    assert "\n" not in str(caught.value)
