"""Who may move the arm, and for how long."""

import pytest

from armtwin.scenarios.serving.lease import LeaseError, MoverLease


class Clock:
    now = 0.0

    def __call__(self) -> float:
        return self.now


def test_the_arm_has_one_mover_at_a_time() -> None:
    lease = MoverLease()
    key = lease.take()
    with pytest.raises(LeaseError, match="somebody else"):
        lease.take()
    lease.check(key)
    with pytest.raises(LeaseError, match="take it first"):
        lease.check("another key")
    with pytest.raises(LeaseError, match="take it first"):
        lease.check(None)


def test_a_mover_who_is_heard_keeps_the_arm_and_one_who_falls_silent_loses_it() -> None:
    clock = Clock()
    lease = MoverLease(silence_s=15.0, now=clock)
    key = lease.take()
    for clock.now in (10.0, 20.0, 30.0):
        assert lease.hear(key)
    clock.now = 46.0
    assert lease.lapsed
    assert not lease.hear(key)
    assert lease.take() != key


def test_a_mover_who_waits_for_his_turn_is_not_silent() -> None:
    clock = Clock()
    lease = MoverLease(silence_s=15.0, now=clock)
    key = lease.take()
    with lease.at_work():
        clock.now = 100.0
        assert not lease.lapsed
    clock.now = 110.0
    assert lease.hear(key)


def test_an_arm_that_was_given_back_is_free() -> None:
    lease = MoverLease()
    lease.take()
    lease.end()
    assert not lease.held
    assert not lease.lapsed
    lease.take()
