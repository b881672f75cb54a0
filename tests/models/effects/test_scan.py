"""Grids for parameters of which the prediction is no smooth function."""

import numpy as np
import pytest

from models.effects.scan import event_rows, since, steps_around
from tests.support.contexts import context_of


def test_since_is_one_from_its_row_on() -> None:
    np.testing.assert_array_equal(since(context_of(np.zeros((5, 3))), 3.0), [0.0, 0.0, 0.0, 1.0, 1.0])


@pytest.mark.parametrize("n", [3, 40, 500])
def test_events_are_looked_for_at_whole_rows_within_the_recording(n: int) -> None:
    rows = event_rows(context_of(np.zeros((n, 3))), None)
    assert rows[0] == 1.0
    assert rows[-1] == n - 1
    assert all(float(row).is_integer() for row in rows)


def test_steps_lie_evenly_in_ratio_about_a_value() -> None:
    steps = np.array(steps_around(0.02, 1.5, 7))
    assert steps[0] == pytest.approx(0.02 / 1.5)
    assert steps[-1] == pytest.approx(0.03)
    np.testing.assert_allclose(np.diff(np.log(steps)), np.log(1.5) / 3)
