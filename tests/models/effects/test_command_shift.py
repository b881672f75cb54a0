"""Pictures paired with the wrong command."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from armtwin.models.catalogue.registry import Site, effect_named
from tests.support.contexts import context_of, turned


@pytest.mark.parametrize("rows", [1, 3, -2])
def test_each_picture_shows_the_pose_of_so_many_rows_before(rows: int) -> None:
    context = context_of()
    shown = turned("command_shift", context, [rows])
    inside = slice(max(rows, 0), len(context) + min(rows, 0))
    np.testing.assert_array_equal(shown[inside], np.roll(context.q_cmd, rows, axis=0)[inside])


@given(st.integers(-6, 6))
def test_at_the_ends_the_nearest_pose_is_shown(rows: int) -> None:
    context = context_of()
    shown = turned("command_shift", context, [rows])
    end = 0 if rows > 0 else -1
    np.testing.assert_array_equal(shown[end], context.q_cmd[end])


def test_shifts_of_up_to_six_rows_either_way_are_tried_and_none_of_zero() -> None:
    tried = {int(start[0]) for start in effect_named("command_shift").starts(context_of(), Site(), None)}
    assert tried == {*range(-6, 0), *range(1, 7)}
