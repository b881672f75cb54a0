"""Play: the output is dragged by the edges of its gap and rests between them."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from armtwin.models.effects.backlash import play
from tests.support.contexts import context_of, one_joint, turned

DRIVES = st.lists(st.floats(-2.0, 2.0), min_size=2, max_size=30).map(np.array)
WIDTHS = st.floats(0.0, 0.5)


@given(DRIVES, WIDTHS, st.floats(-1.0, 1.0))
def test_the_output_never_leaves_the_gap(drive: np.ndarray, width: float, side: float) -> None:
    assert (np.abs(play(drive, width, side) - drive) <= width / 2 + 1e-12).all()


@given(DRIVES, WIDTHS, st.floats(-1.0, 1.0))
def test_it_does_not_matter_in_how_many_steps_a_move_is_made(drive: np.ndarray, width: float, side: float) -> None:
    halfway = (drive[:-1] + drive[1:]) / 2
    finer = np.empty(2 * len(drive) - 1)
    finer[::2], finer[1::2] = drive, halfway
    np.testing.assert_allclose(play(finer, width, side)[::2], play(drive, width, side), atol=1e-12)


@given(DRIVES, WIDTHS)
def test_moves_within_the_gap_move_nothing(drive: np.ndarray, width: float) -> None:
    within = width * (drive - drive.min()) / max(np.ptp(drive), 1e-9)
    output = play(within, width, 0.0)
    assert np.ptp(output) <= np.ptp(within) / 2 + 1e-12


@given(DRIVES)
def test_without_a_gap_the_output_is_the_drive(drive: np.ndarray) -> None:
    np.testing.assert_allclose(play(drive, 0.0, 1.0), drive, atol=1e-12)


def test_there_and_back_the_output_trails_by_half_a_gap_on_either_way() -> None:
    there = np.linspace(0.0, 0.5, 6)
    output = play(np.concatenate([there, there[::-1]]), 0.02, 0.0)
    np.testing.assert_allclose(output[1:6], there[1:] - 0.01)
    np.testing.assert_allclose(output[7:], there[::-1][1:] + 0.01)


def test_other_joints_are_left_alone() -> None:
    context = context_of()
    error = turned("backlash", context, [0.02, 1.0, 0.0, 0.25, 0.0], joint=2) - context.q_cmd
    assert not error[:, [0, 2]].any()
    assert error[:, 1].any()


def test_a_loaded_gap_rests_on_the_side_that_gravity_pushes_to_whatever_side_it_came_from() -> None:
    there = np.linspace(-0.2, 0.2, 5)
    context = context_of(one_joint(2, np.concatenate([there, there[::-1]])))
    error = (turned("backlash", context, [0.02, 0.0, 1.0], joint=2) - context.q_cmd)[:, 1]
    np.testing.assert_allclose(error, 0.01 * np.sign(context.declared_torque(context.q_cmd)[:, 1]))


def test_a_flank_that_yields_leaves_the_same_gap_after_a_long_way_and_less_after_a_short_one() -> None:
    way = np.concatenate([np.linspace(0.0, 0.5, 6), [0.45, 0.5]])
    hard, soft = play(way, 0.04, 0.0), play(way, 0.04, 0.0, 0.5)
    np.testing.assert_allclose(soft[5], hard[5], atol=1e-3)
    pushed = play(np.array([0.0, 0.015, 0.018]), 0.04, 0.0, 0.5)
    assert pushed[-1] > play(np.array([0.0, 0.015, 0.018]), 0.04, 0.0)[-1]
