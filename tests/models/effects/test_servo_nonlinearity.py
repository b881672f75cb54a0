"""A smooth or periodic error over a joint's angle."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from armtwin.models.catalogue.registry import Site, effect_named
from armtwin.models.errors import InputError
from armtwin.models.world import Command
from tests.support.contexts import context_of, one_joint, turned
from tests.support.worlds import flat_world, with_effect

AMPLITUDES = st.floats(-0.05, 0.05)


def harmonic(sine: float, cosine: float, cycles: float) -> list[float]:
    return [sine, cosine, cycles, 0.0, 0.0, 0.0, 0.0]


def track(*derivatives: float) -> list[float]:
    return [0.0, 0.0, 1.0, *derivatives, 1.0]


@given(AMPLITUDES, AMPLITUDES, st.floats(0.5, 40.0))
def test_the_error_repeats_so_many_times_a_turn(sine: float, cosine: float, cycles: float) -> None:
    angles = np.linspace(-0.5, 0.5, 20)
    errors = [
        turned("servo_nonlinearity", context_of(one_joint(1, at)), harmonic(sine, cosine, cycles), joint=1)[:, 0] - at
        for at in (angles, angles + 2 * np.pi / cycles)
    ]
    np.testing.assert_allclose(errors[0], errors[1], atol=1e-9)


@given(AMPLITUDES, AMPLITUDES, st.floats(1.0, 20.0))
def test_amplitude_and_phase_describe_the_same_error(sine: float, cosine: float, cycles: float) -> None:
    assume(np.hypot(sine, cosine) * cycles < 0.9)
    physical = effect_named("servo_nonlinearity").physical
    assert physical is not None
    found = physical(context_of(), np.array(harmonic(sine, cosine, cycles)))
    angle = np.linspace(-1.0, 1.0, 50)
    wave = found["amplitude_rad"] * np.sin(found["cycles_per_turn"] * angle + found["phase_rad"])
    np.testing.assert_allclose(wave, sine * np.sin(cycles * angle) + cosine * np.cos(cycles * angle), atol=1e-12)


def test_no_gear_is_bored_outside_itself() -> None:
    with pytest.raises(InputError, match=r"makes an error of amplitude_rad 0\.3; at most 0\.095"):
        with_effect(flat_world(), "servo_nonlinearity", {"amplitude_rad": 0.3, "cycles_per_turn": 10.0}, joint=1)
    fitted = effect_named("servo_nonlinearity").built(context_of(), Site(joint=1), np.array(harmonic(0.2, 0.2, 10.0)))
    with_effect(flat_world(), "servo_nonlinearity", fitted, joint=1)


@pytest.mark.parametrize(("sine", "cosine", "cycles"), [(0.004, 0.0, 3.0), (-0.002, 0.003, 8.0)])
def test_a_gear_that_is_bored_off_its_centre_makes_it_to_first_order(sine: float, cosine: float, cycles: float) -> None:
    context = context_of()
    physical = effect_named("servo_nonlinearity").physical
    assert physical is not None
    parameters = physical(context, np.array(harmonic(sine, cosine, cycles)))
    board = with_effect(flat_world(), "servo_nonlinearity", parameters, joint=1).electronics[0]()
    made = np.array([board(Command(row, 0.0, q)) for row, q in enumerate(context.q_cmd)])
    expected = turned("servo_nonlinearity", context, harmonic(sine, cosine, cycles), joint=1)
    # Overtones are of the order of amplitude times eccentricity (amplitude times cycles).
    assert np.abs(made - expected).max() < 2.0 * cycles * (sine**2 + cosine**2)


def test_a_track_is_wound_so_that_the_joint_errs_as_its_derivatives_say() -> None:
    context = context_of()
    effect, values = effect_named("servo_nonlinearity"), np.array(track(0.05, -0.1, 0.3))
    built = effect.built(context, Site(joint=1), values)
    board = with_effect(flat_world(), "servo_nonlinearity", built, joint=1).electronics[0]()
    made = np.array([board(Command(row, 0.0, q)) for row, q in enumerate(context.q_cmd)])
    np.testing.assert_allclose(made, turned("servo_nonlinearity", context, values.tolist(), joint=1), atol=2e-5)


def test_each_form_is_told_by_its_own_numbers() -> None:
    told = effect_named("servo_nonlinearity").told
    assert told is not None
    assert told(context_of(), np.array(harmonic(0.01, 0.0, 3.0))) == [0, 1, 2]
    assert told(context_of(), np.array(track(0.01, 0.0, 0.0))) == [3, 4, 5]
