"""What servos and their electronics do to commands."""

import numpy as np
import pytest

from armtwin.models.errors import InputError
from armtwin.sim.physics.simulation import simulate_angles
from tests.support.worlds import errors_rad, flat_world, there_and_back, upright_world, with_effect

ARRIVED_RAD = 2e-5


def along(joint: int, angles: list[float]) -> np.ndarray:
    q = np.zeros((len(angles), 3))
    q[:, joint - 1] = angles
    return q


def test_changes_below_the_threshold_are_ignored_until_they_add_up() -> None:
    world = with_effect(flat_world(), "dead_band", {"threshold_rad": 0.05}, joint=1)
    q = along(1, [0.10, 0.13, 0.149, 0.151, 0.13])
    stood = (q + errors_rad(world, q))[:, 0]
    np.testing.assert_allclose(stood, [0.10, 0.10, 0.10, 0.151, 0.151], atol=ARRIVED_RAD)


def test_a_dead_band_leaves_other_joints_alone() -> None:
    world = with_effect(flat_world(), "dead_band", {"threshold_rad": 0.05}, joint=1)
    assert np.abs(errors_rad(world, there_and_back(2, -0.1, 0.1, 5))[:, 1]).max() < ARRIVED_RAD


def test_coarse_commands_land_on_steps() -> None:
    world = with_effect(flat_world(), "quantization", {"step_rad": 0.02})
    q = np.random.default_rng(0).uniform(-0.3, 0.3, (10, 3))
    stood = (q + errors_rad(world, q)) / 0.02
    np.testing.assert_allclose(stood, np.round(stood), atol=2e-3)
    assert np.abs(errors_rad(world, q)).max() <= 0.01 + ARRIVED_RAD


def test_a_wrong_gain_is_a_share_of_the_angle() -> None:
    world = with_effect(flat_world(), "servo_gain", {"gain": 1.05}, joint=3)
    q = there_and_back(3, -0.6, 0.6, 5)
    np.testing.assert_allclose(errors_rad(world, q)[:, 2], 0.05 * q[:, 2], atol=ARRIVED_RAD)


def test_an_eccentric_gear_errs_periodically_with_its_amplitude() -> None:
    parameters = {"amplitude_rad": 0.01, "cycles_per_turn": 12.0, "phase_rad": 0.0}
    world = with_effect(flat_world(), "servo_nonlinearity", parameters, joint=3)
    period = 2 * np.pi / 12.0
    q = along(3, [*np.linspace(-0.25, 0.25, 21), *(np.linspace(-0.25, 0.25, 21) + period)])
    error = errors_rad(world, q)[:, 2]
    np.testing.assert_allclose(error[:21], error[21:], atol=2 * ARRIVED_RAD)
    assert np.abs(error).max() == pytest.approx(0.01, rel=0.03)
    assert np.interp(np.pi / 24, q[:21, 2], error[:21]) == pytest.approx(0.01, rel=0.03)  # a quarter of a cycle on


def test_an_eccentric_gear_has_overtones() -> None:
    parameters = {"amplitude_rad": 0.02, "cycles_per_turn": 6.0, "phase_rad": 0.0}
    world = with_effect(flat_world(), "servo_nonlinearity", parameters, joint=3)
    q = along(3, list(np.linspace(-np.pi / 6, np.pi / 6, 24, endpoint=False)))
    spectrum = np.abs(np.fft.rfft(errors_rad(world, q)[:, 2]))
    assert spectrum[2] > 0.02 * spectrum[1]


def test_a_warming_servo_creeps_and_settles() -> None:
    world = with_effect(flat_world(), "thermal_drift", {"drift_rad": 0.02, "time_constant_s": 60.0}, joint=1)
    time_s = np.array([0.0, 30.0, 60.0, 120.0, 600.0])
    error = errors_rad(world, np.zeros((5, 3)), time_s)[:, 0]
    assert error[0] == pytest.approx(0.0, abs=ARRIVED_RAD)
    assert (np.diff(error) > 0).all()
    assert error[-1] - error[2] == pytest.approx(0.02 * np.exp(-1), rel=0.005)
    assert error[-1] == pytest.approx(0.02, rel=0.02)  # of which the winding, warm at once, makes a hundredth


def test_a_horn_slips_once() -> None:
    world = with_effect(upright_world(), "joint_slip", {"jump_rad": -0.03, "from_sample": 3}, joint=2)
    error = errors_rad(world, there_and_back(2, -0.2, 0.2, 3))[:, 1]
    np.testing.assert_allclose(error, [0, 0, 0, -0.03, -0.03, -0.03], atol=ARRIVED_RAD)


def test_a_picture_taken_too_early_shows_a_part_of_the_step_to_go() -> None:
    world = with_effect(upright_world(), "settling_lag", {"remaining1": 0.1, "remaining2": 0.3, "remaining3": 0.02})
    q = np.array([[0.0, 0.0, 0.0], [0.2, 0.0, 0.0], [0.2, 0.2, 0.0], [0.2, 0.2, 0.2]])
    error = errors_rad(world, q)
    assert error[1, 0] == pytest.approx(-0.02, rel=0.15)
    assert error[2, 1] == pytest.approx(-0.06, rel=0.1)
    assert error[2, 0] == pytest.approx(0.1 * error[1, 0], abs=5e-4)
    assert error[3, 2] == pytest.approx(-0.004, abs=2e-3)


def test_a_sluggish_arm_lives_through_the_time_that_the_record_states() -> None:
    world = with_effect(flat_world(), "settling_lag", {"remaining": 0.25, "wait_s": 1.0})
    q = along(1, [0.0, 0.2, 0.2, 0.4])
    given = np.array([0.0, 2.0, 4.0, 6.0])
    to_go = [q[:, 0] - simulate_angles(world, q, given + after, commanded_s=given)[:, 0] for after in (0.5, 1.0, 2.0)]
    # From one command to the next a sixteenth is left: two waits of a second.
    np.testing.assert_allclose(to_go[0], [0.0, 0.1, 0.1 / 16, 0.1 + 0.1 / 256], rtol=0.03, atol=2e-4)
    np.testing.assert_allclose(to_go[1], [0.0, 0.05, 0.05 / 16, 0.05 + 0.05 / 256], rtol=0.03, atol=2e-4)
    np.testing.assert_allclose(to_go[2], [0.0, 0.2 / 16, 0.2 / 256, 0.2 / 16], rtol=0.03, atol=2e-4)


def test_a_bench_without_a_clock_waits_as_long_as_the_parts_are_stated_for() -> None:
    world = with_effect(flat_world(), "settling_lag", {"remaining": 0.25, "wait_s": 4.0})
    q = along(1, [0.0, 0.2])
    assert q[1, 0] - simulate_angles(world, q)[1, 0] == pytest.approx(0.05, rel=0.02)


def test_a_step_that_never_ends_is_refused() -> None:
    with pytest.raises(InputError, match=r"remaining: found 1\.0, a number from 0 to 0\.99 is wanted"):
        with_effect(flat_world(), "settling_lag", {"remaining": 1.0})


def test_the_arm_stays_where_it_was_when_a_command_is_missed() -> None:
    world = with_effect(flat_world(), "missed_command", {"samples": [2]})
    q = along(1, [0.1, 0.2, 0.3, 0.4])
    stood = (q + errors_rad(world, q))[:, 0]
    np.testing.assert_allclose(stood, [0.1, 0.2, 0.2, 0.4], atol=ARRIVED_RAD)
