"""A dead band: changes below the threshold are ignored, larger ones are followed all the way."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from armtwin.models.catalogue.registry import Evidence, Site, effect_named
from armtwin.models.world import Command
from tests.support.contexts import context_of, one_joint, turned
from tests.support.worlds import flat_world, with_effect

PATHS = st.lists(st.floats(-1.0, 1.0), min_size=1, max_size=30)


def held(path: object, threshold: float) -> np.ndarray:
    return turned("dead_band", context_of(one_joint(3, path)), [threshold], joint=3)[:, 2]


@given(PATHS, st.floats(0.0, 0.5))
def test_the_output_is_never_the_threshold_or_more_away_from_the_command(path: list[float], threshold: float) -> None:
    assert (np.abs(held(path, threshold) - path) <= max(threshold, 0.0)).all()


@given(PATHS, st.floats(1e-3, 0.5))
def test_the_output_moves_only_to_the_command_itself(path: list[float], threshold: float) -> None:
    output = held(path, threshold)
    moved = np.flatnonzero(np.diff(output)) + 1
    np.testing.assert_array_equal(output[moved], np.array(path)[moved])


@given(PATHS)
def test_a_threshold_of_nothing_changes_nothing(path: list[float]) -> None:
    np.testing.assert_array_equal(held(path, 0.0), path)


@given(PATHS, st.floats(1e-3, 0.5))
def test_the_simulated_servo_s_board_ignores_the_same_changes(path: list[float], threshold: float) -> None:
    board = with_effect(flat_world(), "dead_band", {"threshold_rad": threshold}, joint=3).electronics[0]()
    sent = [board(Command(row, 0.0, np.array([0.0, 0.0, angle])))[2] for row, angle in enumerate(path)]
    np.testing.assert_array_equal(sent, held(path, threshold))


def suggested(path: np.ndarray, true: list[float]) -> list[np.ndarray]:
    """Return what is suggested where joint 1 departs as such a servo does, with noise of a milliradian."""
    context = context_of(one_joint(1, path))
    off = (turned("dead_band", context, true, joint=1) - context.q_cmd)[:, 0]
    off += 1e-3 * np.random.default_rng(0).standard_normal(len(off))
    n = context.q_cmd.shape[1]
    pull = np.zeros((len(off), n))
    pull[:, 0] = off / 1e-6
    evidence = Evidence(pull, np.tile(np.eye(n) / 1e-6, (len(off), 1, 1)), context.q_cmd)
    screen = effect_named("dead_band").screen
    assert screen is not None
    return list(screen(context, Site(joint=1), evidence))


@pytest.mark.parametrize("short", [0.0, 0.17, 0.4])
@pytest.mark.parametrize("threshold", [0.02, 0.05, 0.11])
def test_the_threshold_is_seen_in_the_departures_among_all_at_once(threshold: float, short: float) -> None:
    path = 0.4 * np.sin(np.linspace(0.0, 9.0, 90)) + 0.2 * np.sin(np.linspace(0.0, 25.0, 90))
    best = suggested(path, [threshold, short])[0]
    context = context_of(one_joint(1, path))
    true, found = (turned("dead_band", context, values, joint=1) for values in ([threshold, short], best))
    assert np.abs(true - found).max() < 0.003


def test_of_a_joint_that_never_moves_no_threshold_is_looked_for() -> None:
    assert suggested(np.zeros(20), [0.05, 0.0]) == []


def test_a_motor_that_stops_short_leaves_a_share_of_the_threshold_on_the_side_it_came_from() -> None:
    path = [0.0, 0.1, 0.13, 0.0]
    out = turned("dead_band", context_of(one_joint(1, path)), [0.05, 0.2], joint=1)[:, 0]
    np.testing.assert_allclose(out, [0.0, 0.09, 0.09, 0.01])
