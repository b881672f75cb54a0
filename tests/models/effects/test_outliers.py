"""Gross detection errors: single markers found far from where they are."""

import numpy as np
import pytest

from armtwin.models.catalogue.registry import View, effect_named
from tests.support.contexts import active, context_of, pixels

NOISE_PX = 0.1


def found(view: View) -> set[tuple[int, int]]:
    how = effect_named("outliers").found
    assert how is not None
    find = how.find
    return {(int(row), int(column)) for _, values in find(context_of(), view) for row, column in values.reshape(-1, 2)}


def noisy(observed: np.ndarray, seed: int = 3) -> View:
    noise = NOISE_PX * np.random.default_rng(seed).standard_normal(observed.shape)
    return View(observed + noise, pixels(context_of()), NOISE_PX)


@pytest.mark.parametrize("seed", range(5))
def test_exactly_the_sightings_that_are_wrong_are_found(seed: int) -> None:
    rng = np.random.default_rng(seed)
    observed = pixels(context_of())
    wrong = {(int(row), int(rng.integers(4))) for row in rng.choice(40, 5, replace=False)}
    for row, column in wrong:
        observed[row, column] += 20.0 * np.array([np.cos(row), np.sin(row)])
    assert found(noisy(observed)) == wrong


@pytest.mark.parametrize("seed", range(5))
def test_noise_alone_has_none(seed: int) -> None:
    assert found(noisy(pixels(context_of()), seed)) == set()


def test_a_jump_that_lasts_is_no_detection_error() -> None:
    context = context_of()
    assert found(noisy(pixels(context, active("joint_slip", [0.1, 20.0], joint=1)))) == set()


def test_a_pose_at_which_the_whole_arm_is_elsewhere_is_none_either() -> None:
    assert found(noisy(pixels(context_of(), active("missed_command", [15])))) <= {(15, 1)}


def test_a_single_turn_of_the_last_joint_is_a_step_of_the_servo_and_no_detection_error() -> None:
    turned = pixels(context_of(), active("joint_slip", [0.05, 20.0], joint=3))
    observed = pixels(context_of())
    observed[20] = turned[20]
    assert found(noisy(observed)) == set()


def test_what_is_less_than_a_tenth_of_a_pixel_off_is_no_gross_error_for_the_quietest_camera() -> None:
    predicted = pixels(context_of())
    noise = 0.004 * np.random.default_rng(3).standard_normal(predicted.shape)
    for off, expected in ((0.05, set()), (0.2, {(20, 2)})):
        observed = predicted + noise
        observed[20, 2, 0] += off
        assert found(View(observed, predicted, 0.004)) == expected
