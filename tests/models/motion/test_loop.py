"""The servo's loop in time does what its closed forms say."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from armtwin.models.motion.loop import INDEX, follow, neutral, received

Array = NDArray[np.float64]


def followed(time: Array, sent: Array, load: float = 0.0, **values: float) -> Array:
    p = neutral()
    for name, value in values.items():
        p[INDEX[name]] = value
    first = np.zeros(len(time), dtype=bool)
    first[0] = True
    return follow(time, time, sent, np.full(len(time), load), np.zeros(len(time)), first, np.ones(len(time), bool), p)


def step(height: float, rate: float = 100.0, seconds: float = 1.0) -> tuple[Array, Array]:
    time = np.arange(0.0, seconds, 1.0 / rate)
    return time, np.full(len(time), height)


@given(st.floats(0.01, 0.1), st.floats(30.0, 500.0))
@settings(max_examples=25, deadline=None)
def test_the_nominal_servo_closes_an_error_exponentially(height: float, rate: float) -> None:
    time, sent = step(height, rate)
    np.testing.assert_allclose(followed(time, sent), height * (1.0 - np.exp(-time / 0.020)), atol=1e-9)


def test_a_large_step_is_taken_at_the_speed_limit() -> None:
    time, sent = step(1.0)
    angle = followed(time, sent, speed_rad_s=2.0)
    np.testing.assert_allclose(angle[:40], 2.0 * time[:40], atol=1e-9)


@given(st.floats(0.0, 0.2))
@settings(max_examples=25, deadline=None)
def test_a_delay_moves_the_answer_in_time_whatever_part_of_a_row_it_is(delay: float) -> None:
    time, sent = step(0.05)
    sent[0] = 0.0
    late = np.maximum(time - time[1] - delay, 0.0)
    np.testing.assert_allclose(followed(time, sent, delay_s=delay), 0.05 * (1.0 - np.exp(-late / 0.020)), atol=1e-6)


def test_dry_friction_stops_the_shaft_short_by_itself_over_the_stiffness() -> None:
    time, sent = step(0.05, seconds=3.0)
    assert followed(time, sent, coulomb_rad=0.012)[-1] == pytest.approx(0.05 - 0.012, abs=1e-9)
    assert followed(time, np.full(len(time), 0.01), coulomb_rad=0.012)[-1] == 0.0


def test_a_proportional_servo_sags_by_its_load() -> None:
    time, sent = step(0.3, seconds=3.0)
    assert followed(time, sent, load=0.5, droop_rad_nm=0.1)[-1] == pytest.approx(0.25, abs=1e-9)


def test_play_follows_a_reversal_only_after_the_gap() -> None:
    time = np.arange(0.0, 8.0, 0.02)
    sent = 0.2 * np.sin(2 * np.pi * time / 4.0)
    angle = followed(time, sent, play_rad=0.04)
    shaft = followed(time, sent)
    assert np.abs(angle - shaft).max() == pytest.approx(0.02, abs=1e-6)
    top = int(np.argmax(angle[:100]))
    assert np.ptp(angle[top : top + 5]) < 1e-3


def test_inertia_answers_in_second_order() -> None:
    time, sent = step(0.01, rate=200.0)
    inertia, tau = 0.0004, 0.020
    damping, pulse = tau / (2 * inertia), np.sqrt(1 / inertia - (tau / (2 * inertia)) ** 2)
    ring = np.exp(-damping * time) * (np.cos(pulse * time) + damping / pulse * np.sin(pulse * time))
    np.testing.assert_allclose(followed(time, sent, inertia_s2=inertia), 0.01 * (1.0 - ring), atol=4e-4)


def test_commands_within_the_dead_band_are_not_heard_and_others_wholly() -> None:
    p = neutral()
    p[INDEX["dead_band_rad"]] = 0.02
    np.testing.assert_array_equal(received(np.array([0.0, 0.015, 0.03, 0.04, 0.06]), p), [0.0, 0.0, 0.03, 0.03, 0.06])


def test_no_later_measured_angle_is_looked_at() -> None:
    time, sent = step(0.05)
    first = np.append(True, np.zeros(len(time) - 1, dtype=bool))
    every = np.ones(len(time), dtype=bool)
    load = np.zeros(len(time))
    one = follow(time, time, sent, load, np.zeros(len(time)), first, every, neutral())
    other = follow(time, time, sent, load, np.append(0.0, np.full(len(time) - 1, 7.0)), first, every, neutral())
    np.testing.assert_array_equal(one, other)
