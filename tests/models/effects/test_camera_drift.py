"""The camera creeps."""

import numpy as np

from tests.support.contexts import active, context_of, pixels

CREEP = [0.002, -0.001, 0.003, 0.2, 0.1, -0.3]


def test_at_the_last_picture_it_stands_where_a_bump_of_the_same_size_would_have_put_it() -> None:
    context = context_of()
    drifted = pixels(context, active("camera_drift", CREEP))
    bumped = pixels(context, active("camera_moved", [*CREEP, 1.0]))
    np.testing.assert_allclose(drifted[-1], bumped[-1], atol=1e-9)


def test_it_begins_where_it_was_assumed_and_creeps_on_with_every_picture() -> None:
    context = context_of(np.zeros((20, 3)))
    moved = np.linalg.norm(pixels(context, active("camera_drift", CREEP)) - pixels(context), axis=-1)
    assert not moved[0].any()
    assert (np.diff(moved, axis=0) > 0).all()


def test_where_times_are_known_it_creeps_with_time_and_not_with_the_number_of_pictures() -> None:
    times = np.array([0.0, 1.0, 2.0, 3.0, 103.0])
    context = context_of(np.zeros((5, 3)), time_s=times)
    moved = np.linalg.norm(pixels(context, active("camera_drift", CREEP)) - pixels(context), axis=-1)
    assert (moved[3] < 0.05 * moved[4]).all()
