import numpy as np
import pytest

from armtwin.models.commands import moving_commands, settled_commands
from tests.support.contexts import context_of, one_joint, turned

Q = np.array([[0.0], [0.1], [0.3], [0.2]])


def test_a_settled_row_shows_its_own_command_given_when_the_row_before_was_seen() -> None:
    series = settled_commands(Q, np.array([2.0, 4.0, 7.0, 9.0]))
    np.testing.assert_array_equal(series.in_force, [0, 1, 2, 3])
    np.testing.assert_allclose(series.given_s, [0.0, 2.0, 4.0, 7.0])  # the first a usual wait before it was seen
    np.testing.assert_allclose(series.waits_s, [2.0, 2.0, 3.0, 2.0])
    np.testing.assert_allclose(series.spans_s, series.waits_s)


def test_a_recorded_time_of_a_command_goes_before_the_assumed_one_row_by_row() -> None:
    series = settled_commands(Q, np.array([2.0, 4.0, 7.0, 9.0]), np.array([1.5, np.nan, 6.0, 8.0]))
    np.testing.assert_allclose(series.given_s, [1.5, 2.0, 6.0, 8.0])
    np.testing.assert_allclose(series.spans_s, [0.5, 4.0, 2.0, 1.0])


def test_without_times_rows_count() -> None:
    series = settled_commands(Q, None, np.array([1.5, 3.0, 6.0, 8.0]))
    assert not series.timed
    np.testing.assert_allclose(series.waits_s, 1.0)


def test_a_row_of_a_moving_arm_is_read_before_its_command_acts() -> None:
    series = moving_commands(Q, np.array([0.0, 0.02, 0.04, 0.06]))
    np.testing.assert_array_equal(series.in_force, [0, 0, 1, 2])
    np.testing.assert_allclose(series.sampled(series.q)[:, 0], [0.0, 0.0, 0.1, 0.3])


def test_a_delayed_arm_has_an_earlier_command_in_force() -> None:
    series = moving_commands(Q, np.array([0.0, 0.02, 0.04, 0.06]))
    seen = series.seen_s
    np.testing.assert_allclose(series.at(seen)[:, 0], [0.0, 0.0, 0.1, 0.3])
    np.testing.assert_allclose(series.at(seen, delay_s=0.03)[:, 0], [0.0, 0.0, 0.0, 0.1])
    np.testing.assert_allclose(series.at(np.array([10.0]))[:, 0], 0.2)


@pytest.mark.parametrize(
    ("effect", "values"), [("backlash", [0.06, 0.0, 0.0]), ("hysteresis", [0.02, 0.05, 0.0]), ("dead_band", [0.05])]
)
def test_what_remembers_steps_through_the_commands_and_is_sampled_when_rows_are_seen(
    effect: str, values: list[float]
) -> None:
    q = one_joint(1, [0.0, 0.1, 0.3, 0.2, 0.19, 0.35])
    seen = 0.02 * np.arange(len(q))
    settled = turned(effect, context_of(q, time_s=seen), values, joint=1)
    moving = turned(effect, context_of(q, time_s=seen, moving=True), values, joint=1)
    assert np.abs(settled[1:] - settled[:-1]).max() > 0.01
    np.testing.assert_array_equal(moving[1:], settled[:-1])


def test_a_lagging_arm_goes_on_between_a_picture_and_the_next_command() -> None:
    q = one_joint(1, [0.0, 0.2, 0.4])
    seen = np.array([1.0, 3.0, 5.0])
    lag = np.array([0.25, 0.0, 0.0])
    at_once = turned("settling_lag", context_of(q, time_s=seen), lag)
    waited = turned("settling_lag", context_of(q, time_s=seen, commanded_s=seen - 1.0), lag)
    # A quarter of the step is left in the picture; a wait later, at the next command, a sixteenth.
    np.testing.assert_allclose(at_once[:, 0], [0.0, 0.15, 0.4 - 0.25 * 0.25])
    np.testing.assert_allclose(waited[:, 0], [0.0, 0.15, 0.4 - 0.25 * (0.2 + 0.2 / 16)])
