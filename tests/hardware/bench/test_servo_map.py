import numpy as np
import pytest

from armtwin.hardware.bench.bench_file import BenchSetup
from armtwin.hardware.bench.servo_map import ServoMap


def test_pulse_is_zero_plus_slope_times_angle(setup: BenchSetup):
    np.testing.assert_allclose(setup.servo_map.pulses_us(np.array([0.5, 0.5, 0.5])), [1818.31, 1181.69, 1750.0])


def test_a_joint_on_another_servo_gets_that_servos_pulse():
    crossed = ServoMap(np.array([2, 0, 1]), np.array([1500.0, 1600.0, 1400.0]), np.array([600.0, 600.0, 600.0]))

    np.testing.assert_allclose(crossed.pulses_us(np.zeros(3)), [1600.0, 1400.0, 1500.0])


@pytest.mark.parametrize("servos", [[0, 1, 2], [2, 0, 1], [1, 0, 2]])
def test_angles_are_the_inverse_of_pulses_for_any_wiring(servos: list[int]):
    wired = ServoMap(np.array(servos), np.array([1500.0, 1600.0, 1400.0]), np.array([636.0, -600.0, 580.0]))
    q = np.random.default_rng(1).uniform(-1, 1, (50, 3))

    np.testing.assert_allclose(wired.angles_rad(wired.pulses_us(q)), q, atol=1e-14)
