import numpy as np
import pytest

from armtwin.models.arm import Arm, nominal_arm
from armtwin.models.camera import project
from armtwin.models.camera_files import nominal_camera
from armtwin.models.coordinate_frames import robot_to_board
from armtwin.models.kinematics import marker_positions
from armtwin.sim.sealed.plans import draw_plan
from tests.support.worlds import BASE_MM, PLANE_MM

SEEDS = pytest.mark.parametrize("seed", range(5))


@SEEDS
def test_two_trajectories_are_held_out_and_never_the_first(seed: int) -> None:
    plan, held_out = draw_plan(np.random.default_rng(seed), nominal_arm(), 150)
    names = list(dict.fromkeys(plan.trajectory.tolist()))
    assert len(set(held_out)) == 2
    assert set(held_out) < set(names[1:])


@SEEDS
def test_the_drawn_arm_stays_in_the_picture(seed: int) -> None:
    plan, _ = draw_plan(np.random.default_rng(seed), nominal_arm(), 150)
    points = marker_positions(nominal_arm(), plan.q_cmd).reshape(-1, 2)
    pixels = project(nominal_camera(), robot_to_board(points, np.array([*BASE_MM, PLANE_MM])))
    assert (pixels > 0).all()
    assert (pixels < [1279, 719]).all()


def test_a_plan_has_about_as_many_poses_as_were_asked_for() -> None:
    plan, _ = draw_plan(np.random.default_rng(0), nominal_arm(), 150)
    assert 120 <= len(plan) <= 180


def test_chains_get_plans_in_joint_space() -> None:
    plan, held_out = draw_plan(np.random.default_rng(0), Arm("chain", np.full(4, 90.0), np.zeros(2)), 100)
    assert plan.q_cmd.shape[1] == 4
    assert held_out
