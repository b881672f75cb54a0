"""Motions of one arm as one log: clocks that begin anew, times that are missing, two clocks."""

from __future__ import annotations

import numpy as np
import pytest

from armtwin.models.errors import InputError
from armtwin.models.importers.clocks import on_clock_of
from armtwin.models.importers.log import JointLog, checked, joined

N = 40


def log(name: str, joints: tuple[str, ...] = ("elbow",), begin_s: float = 0.0) -> JointLog:
    time = begin_s + 0.02 * np.arange(N)
    q = np.tile(np.sin(5 * time)[:, None], len(joints))
    return JointLog(joints, time, np.full(N, name), q, 0.9 * q)


def test_motions_whose_clocks_begin_anew_are_laid_one_after_another() -> None:
    both = joined([log("one"), log("two")])
    assert (np.diff(both.time_s) > 0).all()
    assert both.time_s[N] - both.time_s[N - 1] == pytest.approx(5.0)
    np.testing.assert_allclose(np.diff(both.time_s[N:]), 0.02)
    assert both.notes == ("each trajectory's clock begins anew: they are laid 5 s apart",)


def test_motions_of_one_clock_stay_where_they_are() -> None:
    both = joined([log("one"), log("two", begin_s=9.0)])
    assert both.time_s[N] == 9.0
    assert not both.notes


def test_motions_of_other_joints_are_not_joined() -> None:
    with pytest.raises(InputError, match="two: its joints are wrist, those of one elbow; import them apart"):
        joined([log("one"), log("two", ("wrist",))])


def test_a_time_that_is_missing_is_named() -> None:
    holed = log("one")
    holed.time_s[7] = np.nan
    with pytest.raises(InputError, match="row 8: its time is missing"):
        checked(holed, "log.csv")


def test_seven_joints_move_and_eight_are_too_many() -> None:
    assert len(checked(log("one", tuple("abcdefg")), "log.csv").joints) == 7
    with pytest.raises(InputError, match=r"8 joints .* a recording has 1 to 7"):
        checked(log("one", tuple("abcdefgh")), "log.csv")


def wander(seed: int = 3, n: int = 2000) -> tuple[np.ndarray, np.ndarray]:
    """(n,) times and (n, 2) commands without a period."""
    steps = np.random.default_rng(seed).uniform(-0.5, 0.5, (n // 50, 2))
    return 0.02 * np.arange(n), np.repeat(steps, 50, axis=0)


@pytest.mark.parametrize("apart_s", [-7200.0, 86400.25, 1.7e9])
def test_commands_of_another_clock_are_brought_to_that_of_the_readings(apart_s: float) -> None:
    time, sent = wander()
    moved, note = on_clock_of(time, sent, time + apart_s, sent, "log")
    np.testing.assert_allclose(moved, time, atol=0.03)
    assert note is not None
    assert ("ahead of" if apart_s > 0 else "behind") in note


def test_commands_of_one_clock_are_left_alone_however_late_the_arm_is() -> None:
    time, sent = wander()
    moved, note = on_clock_of(time + 0.3, sent, time, sent, "log")
    assert moved is time
    assert note is None


def test_two_clocks_of_which_nothing_is_alike_are_refused() -> None:
    time, sent = wander()
    with pytest.raises(InputError, match="on two clocks, 900 s apart, and no shift makes them alike"):
        on_clock_of(time, wander(4)[1], time + 900.0, sent, "log")
