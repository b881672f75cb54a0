"""Play and friction at a joint: what they do depends on where the arm came from."""

import numpy as np
import pytest

from armtwin.models.errors import InputError
from armtwin.models.world import World
from tests.support.worlds import errors_rad, flat_world, there_and_back, upright_world, with_effect

WORLDS = pytest.mark.parametrize("world", [flat_world(), upright_world()], ids=["flat", "upright"])


@WORLDS
@pytest.mark.parametrize("joint", [1, 2, 3])
def test_play_leaves_the_link_half_a_gap_behind_on_either_way(world: World, joint: int) -> None:
    q = there_and_back(joint, -0.2, 0.2, 7)
    played = with_effect(world, "backlash", {"width_rad": 0.02}, joint=joint)
    error = errors_rad(played, q)[:, joint - 1]
    np.testing.assert_allclose(error[1:7], -0.01, atol=3e-4)
    np.testing.assert_allclose(error[8:], 0.01, atol=3e-4)


def test_a_move_within_the_gap_does_not_move_the_link() -> None:
    q = np.zeros((3, 3))
    q[:, 1] = [0.2, 0.194, 0.188]
    played = with_effect(flat_world(), "backlash", {"width_rad": 0.02}, joint=2)
    stood = q[:, 1] + errors_rad(played, q)[:, 1]
    np.testing.assert_allclose(stood, stood[0], atol=1e-4)


def test_a_loose_link_falls_to_its_loaded_side_whichever_way_it_came() -> None:
    # Link 2 points left, so its weight turns it counter-clockwise: towards the upper stop.
    played = with_effect(upright_world(), "backlash", {"width_rad": 0.02, "gravity_loaded": 1}, joint=2)
    error = errors_rad(played, there_and_back(2, -0.2, 0.2, 4))[:, 1]
    np.testing.assert_allclose(error, 0.01, atol=1e-4)


def test_play_moves_no_other_joint() -> None:
    played = with_effect(upright_world(), "backlash", {"width_rad": 0.02}, joint=2)
    error = errors_rad(played, there_and_back(2, -0.2, 0.2, 4))
    assert np.abs(error[:, [0, 2]]).max() < 3e-5


@WORLDS
def test_friction_holds_the_link_back_by_its_lag_after_long_travel(world: World) -> None:
    rubbed = with_effect(world, "hysteresis", {"lag_rad": 0.01, "length_rad": 0.04}, joint=2)
    error = errors_rad(rubbed, there_and_back(2, -0.2, 0.2, 9))[:, 1]
    assert error[8] == pytest.approx(-0.01, rel=0.03)
    assert error[-1] == pytest.approx(0.01, rel=0.03)


def test_friction_changes_the_lag_gradually_after_a_reversal() -> None:
    rubbed = with_effect(flat_world(), "hysteresis", {"lag_rad": 0.01, "length_rad": 0.04}, joint=2)
    q = np.zeros((40, 3))
    q[:20, 1] = np.linspace(-0.2, 0.2, 20)
    q[20:, 1] = 0.2 - 0.005 * np.arange(1, 21)
    swing = errors_rad(rubbed, q)[19:, 1] + 0.01  # 0 at the reversal, 0.02 when it has turned over
    travelled = 0.005 * np.arange(21)
    assert (np.diff(swing) > 0).all()
    assert np.interp(0.04, travelled, swing) == pytest.approx(0.02 * (1 - np.exp(-1)), rel=0.1)
    assert swing[1] < 0.2 * 0.02


def test_friction_that_would_let_the_link_jump_is_refused() -> None:
    with pytest.raises(InputError, match=r"length_rad 0\.01 is too short for lag_rad 0\.01"):
        with_effect(flat_world(), "hysteresis", {"lag_rad": 0.01, "length_rad": 0.01}, joint=1)
