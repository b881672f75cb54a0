"""Single poses at which the arm stayed where it was."""

from dataclasses import replace

import numpy as np
import pytest

from armtwin.models.catalogue.registry import Site, View, effect_named
from tests.support.contexts import active, context_of, pixels, turned

NOISE_PX = 0.1


def view_of(missed: list[int], noise_px: float = NOISE_PX, n: int = 40) -> View:
    context = context_of()
    observed = pixels(context, active("missed_command", missed))
    rng = np.random.default_rng(1)
    return View(observed + noise_px * rng.standard_normal(observed.shape), pixels(context), noise_px)


def test_the_arm_holds_the_command_before() -> None:
    context = context_of()
    out = turned("missed_command", context, [7])
    np.testing.assert_array_equal(out[7], context.q_cmd[6])
    np.testing.assert_array_equal(np.delete(out, 7, axis=0), np.delete(context.q_cmd, 7, axis=0))


def test_of_two_missed_in_a_row_both_hold_the_last_one_that_arrived() -> None:
    context = context_of()
    np.testing.assert_array_equal(turned("missed_command", context, [7, 8])[8], context.q_cmd[6])


@pytest.mark.parametrize("missed", [[5], [5, 20, 33], [10, 11, 12]])
def test_missed_poses_are_found_among_the_others(missed: list[int]) -> None:
    how = effect_named("missed_command").found
    assert how is not None
    find = how.find
    ((site, rows),) = find(context_of(), view_of(missed))
    assert site == Site()
    np.testing.assert_array_equal(rows, missed)


def test_where_every_command_arrived_none_is_found() -> None:
    how = effect_named("missed_command").found
    assert how is not None
    find = how.find
    assert find(context_of(), view_of([])) == []


def test_a_gross_error_that_agrees_with_no_pose_is_no_missed_command() -> None:
    how = effect_named("missed_command").found
    assert how is not None
    find = how.find
    view = view_of([])
    view.observed[15, 3] += 60.0
    assert find(context_of(), view) == []


def test_the_simulated_bench_is_told_the_samples() -> None:
    physical = effect_named("missed_command").physical
    assert physical is not None
    assert physical(context_of(), np.array([3.0, 9.0])) == {"samples": [3, 9]}


def test_a_marker_that_hardly_moves_on_the_way_need_not_miss_its_own_pose_by_as_much_as_the_others() -> None:
    how = effect_named("missed_command").found
    assert how is not None
    find = how.find
    predicted = np.array([[[0.0, 0.0], [0.0, 0.0]], [[0.9, 0.0], [15.0, 0.0]], [[0.0, 9.0], [30.0, 9.0]]])
    observed = predicted[[0, 0, 2]] + np.array([[0.0, 0.0], [0.15, 0.0], [0.0, 0.0]])[:, None]
    ((_, rows),) = find(context_of(), View(observed, predicted, 0.1))
    assert rows.tolist() == [1]


def test_a_joint_whose_packet_was_lost_stays_while_the_others_move() -> None:
    context = context_of()
    out = turned("missed_command", context, [7 + 2 / 128])
    np.testing.assert_array_equal(out[7], [context.q_cmd[7, 0], context.q_cmd[6, 1], context.q_cmd[7, 2]])


@pytest.mark.parametrize("missed", [[5.0078125], [5.046875, 20.0, 33.03125], [10.015625, 11.0, 12.015625]])
def test_which_joints_stayed_is_found_by_trying_each_set_of_them(missed: list[float]) -> None:
    context = context_of()
    observed = pixels(context, active("missed_command", missed))
    noisy = observed + NOISE_PX * np.random.default_rng(2).standard_normal(observed.shape)

    def replay(commands: np.ndarray) -> np.ndarray:
        return pixels(context_of(commands))

    how = effect_named("missed_command").found
    assert how is not None
    find = how.find
    assert find is not None
    ((_, found),) = find(context, View(noisy, pixels(context), NOISE_PX, replay))
    np.testing.assert_allclose(found, missed)


def test_the_simulated_bench_is_told_which_joint_missed_which_sample() -> None:
    physical = effect_named("missed_command").physical
    assert physical is not None
    assert physical(context_of(), np.array([3.0, 9 + 3 / 128])) == {"samples": [3], "samples1": [9], "samples2": [9]}


def test_a_run_is_found_across_poses_that_nobody_looked_at() -> None:
    context, how = context_of(), effect_named("missed_command").found
    assert how is not None
    seen = view_of([10, 11, 12, 13])
    seen.observed[[11, 12]] = np.nan

    def replay(commands: np.ndarray) -> np.ndarray:
        return pixels(replace(context, q_cmd=commands))

    ((_, rows),) = how.find(context, replace(seen, replay=replay))
    np.testing.assert_array_equal(rows, [10, 11, 12, 13])
