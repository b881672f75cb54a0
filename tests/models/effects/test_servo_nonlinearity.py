"""A smooth or periodic error over a joint's angle."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from models.effects.registry import effect_named
from models.world import Command
from tests.support.contexts import context_of, one_joint, turned
from tests.support.worlds import flat_world, with_effect

AMPLITUDES = st.floats(-0.05, 0.05)


@given(AMPLITUDES, AMPLITUDES, st.floats(0.5, 40.0))
def test_the_error_repeats_so_many_times_a_turn(sine: float, cosine: float, cycles: float) -> None:
    angles = np.linspace(-0.5, 0.5, 20)
    errors = [
        turned("servo_nonlinearity", context_of(one_joint(1, at)), [sine, cosine, cycles], joint=1)[:, 0] - at
        for at in (angles, angles + 2 * np.pi / cycles)
    ]
    np.testing.assert_allclose(errors[0], errors[1], atol=1e-9)


@given(AMPLITUDES, AMPLITUDES, st.floats(1.0, 20.0))
def test_amplitude_and_phase_describe_the_same_error(sine: float, cosine: float, cycles: float) -> None:
    physical = effect_named("servo_nonlinearity").physical
    assert physical is not None
    found = physical(context_of(), np.array([sine, cosine, cycles]))
    angle = np.linspace(-1.0, 1.0, 50)
    wave = found["amplitude_rad"] * np.sin(found["cycles_per_turn"] * angle + found["phase_rad"])
    np.testing.assert_allclose(wave, sine * np.sin(cycles * angle) + cosine * np.cos(cycles * angle), atol=1e-12)


@pytest.mark.parametrize(("sine", "cosine", "cycles"), [(0.004, 0.0, 3.0), (-0.002, 0.003, 8.0)])
def test_a_gear_that_is_bored_off_its_centre_makes_it_to_first_order(sine: float, cosine: float, cycles: float) -> None:
    context = context_of()
    physical = effect_named("servo_nonlinearity").physical
    assert physical is not None
    parameters = physical(context, np.array([sine, cosine, cycles]))
    board = with_effect(flat_world(), "servo_nonlinearity", parameters, joint=1).electronics[0]()
    made = np.array([board(Command(row, 0.0, q)) for row, q in enumerate(context.q_cmd)])
    expected = turned("servo_nonlinearity", context, [sine, cosine, cycles], joint=1)
    # Overtones are of the order of amplitude times eccentricity (amplitude times cycles).
    assert np.abs(made - expected).max() < 2.0 * cycles * (sine**2 + cosine**2)
