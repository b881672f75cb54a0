import time
from pathlib import Path

import numpy as np
import pytest

from armtwin.models.errors import InputError
from armtwin.models.motion_arm import model_arm
from armtwin.models.motion_world import Motion, ideal_motion_world
from armtwin.sim.motion.simulation import simulate_motion
from tests.sim.motion.worlds import followed, run, steps, swing, two_axes, upright

# A hobby encoder of 12 bits has a grain of 1.5 mrad; six links that all start at full speed pull at one another.
NOTHING_RAD = 0.6e-3


@pytest.mark.parametrize("n", [1, 3, 6])
@pytest.mark.parametrize("motion", [swing, steps])
def test_the_nominal_servo_closes_an_error_in_20_ms_at_no_more_than_its_speed(n: int, motion: object) -> None:
    moving = swing(n) if motion is swing else steps(n)
    assert np.abs(run(ideal_motion_world(upright(n)), moving) - followed(moving)).max() < NOTHING_RAD


def test_it_does_so_at_irregular_times_and_on_an_arm_of_any_axes(tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    time_s = np.cumsum(rng.uniform(0.004, 0.02, 400))
    motion = Motion("jittered", time_s, np.repeat(rng.uniform(-0.6, 0.6, (8, 2)), 50, axis=0))
    assert np.abs(run(ideal_motion_world(two_axes(tmp_path)), motion) - followed(motion)).max() < NOTHING_RAD


def test_a_command_stays_in_force_over_the_gap_between_motions() -> None:
    first = Motion("first", np.array([0.0, 0.01]), np.array([[0.0], [0.4]]))
    second = Motion("second", np.array([3.0, 3.01]), np.array([[0.0], [0.0]]))
    readings = run(ideal_motion_world(upright(1)), first, second)
    np.testing.assert_allclose(readings[:, 0], [0.0, 0.0, 0.4, 0.4 - 0.0616], atol=2e-4)


def test_a_motion_may_start_where_the_arm_was_measured() -> None:
    motion = Motion("there", np.arange(100) * 0.01, np.full((100, 1), 0.2))
    readings = simulate_motion(ideal_motion_world(upright(1), np.array([0.05])), [motion], [np.array([0.15])])
    assert readings[0, 0] == pytest.approx(0.15)
    assert readings[-1, 0] == pytest.approx(0.25, abs=1e-4)


def test_it_runs_far_faster_than_time() -> None:
    motion = swing(6, seconds=8.0)
    started = time.process_time()
    run(ideal_motion_world(upright(6)), motion)
    assert time.process_time() - started < 8.0 / 20.0


def test_a_model_that_does_not_load_or_lacks_a_joint_is_refused_by_name(tmp_path: Path) -> None:
    two_axes(tmp_path)
    with pytest.raises(InputError, match="no joint 'yow'; did you mean 'yaw'"):
        model_arm("two", tmp_path / "two.xml", ("yow",))
    (tmp_path / "bad.xml").write_text("<mujoco><worldbody><body></mujoco>")
    with pytest.raises(InputError, match=r"bad.xml: no XML \(mismatched tag"):
        model_arm("bad", tmp_path / "bad.xml", ("yaw",))
