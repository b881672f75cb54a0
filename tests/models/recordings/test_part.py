"""A fair part of a long recording: runs spread over all of it, each led up to."""

import numpy as np
import pytest

from armtwin.models.recordings.part import MOST_POSES, Part, fair_part, part_of, shortened
from tests.support.recordings import recording


@pytest.mark.parametrize("n", [700, 5_000, 400_000])
def test_a_part_is_spread_over_the_whole_and_of_the_size_that_is_wanted(n: int) -> None:
    part = fair_part(n, 600)
    assert 0.9 * 600 <= part.counted.sum() <= 600
    quarters = np.histogram(part.rows[part.counted], bins=4, range=(0, n))[0]
    assert quarters.min() > 100


def test_each_run_is_led_up_to_by_poses_that_do_not_count() -> None:
    part = fair_part(5_000, 600)
    first = np.flatnonzero(np.diff(part.rows, prepend=-2) > 1)
    assert not part.counted[first[1:]].any()


def test_a_short_recording_is_looked_at_whole() -> None:
    assert fair_part(600, 600).counted.all()
    short = recording()
    assert shortened(short) is short
    assert len(short) < MOST_POSES


def test_rows_of_the_part_are_found_again_in_the_whole() -> None:
    part = fair_part(5_000, 600)
    assert part.there(part.here(2_345.0, 5_000), 5_000) >= 2_345.0
    assert part.there(float(len(part.rows)), 5_000) == 5_000.0  # never


def test_of_poses_that_only_lead_up_nothing_was_measured() -> None:
    whole = recording()
    part = fair_part(len(whole), len(whole) // 2)
    some = part_of(whole, part)
    seen = np.isfinite(np.stack(list(some.markers_px.values()))).all(axis=(0, 2))
    assert not seen[~part.counted].any()
    np.testing.assert_array_equal(some.q_cmd, whole.q_cmd[part.rows])


def test_a_part_of_a_very_long_recording_is_not_cut_again() -> None:
    short = recording()
    rows = np.resize(np.arange(len(short)), 30_000)
    long = part_of(short, Part(rows, np.ones(len(rows), dtype=bool)))
    once = shortened(long)
    assert MOST_POSES * 0.9 < len(once) < 30_000
    assert shortened(once) is once
