"""Grids for parameters of which the prediction is no smooth function."""

import numpy as np
import pytest

from armtwin.models.catalogue.scan import event_rows, fan_about, since
from tests.support.contexts import context_of


def test_since_is_one_from_its_row_on() -> None:
    np.testing.assert_array_equal(since(context_of(np.zeros((5, 3))), 3.0), [0.0, 0.0, 0.0, 1.0, 1.0])


@pytest.mark.parametrize("n", [3, 40, 500])
def test_events_are_looked_for_at_whole_rows_within_the_recording(n: int) -> None:
    rows = event_rows(context_of(np.zeros((n, 3))), None)
    assert rows[0] == 1.0
    assert rows[-1] == n - 1
    assert all(float(row).is_integer() for row in rows)


def test_a_fan_reaches_every_scale_about_a_value() -> None:
    fan = np.array(fan_about(0.02, 0.1, 1e-4, 4))
    assert fan[4] == 0.02
    np.testing.assert_allclose(
        np.abs(fan / 0.02 - 1.0), [0.1, 1e-2, 1e-3, 1e-4, 0.0, 1e-4, 1e-3, 1e-2, 0.1], atol=1e-12
    )
