import os
import signal

import pytest

from armtwin.scenarios.commands.interrupts import ended_as_by_ctrl_c, interrupts_deferred


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP])
def test_a_signal_to_end_runs_every_finally_and_leaves_its_handler_as_it_was(number: signal.Signals):
    before = signal.getsignal(number)
    released = []

    def hold_the_bench() -> None:
        with ended_as_by_ctrl_c():
            try:
                os.kill(os.getpid(), number)
                signal.pause()
            finally:
                released.append(number)

    with pytest.raises(KeyboardInterrupt):
        hold_the_bench()

    assert released == [number]
    assert signal.getsignal(number) == before


def test_ctrl_c_in_the_middle_of_an_import_comes_behind_it() -> None:
    imported = []

    def start() -> None:
        with interrupts_deferred():
            try:
                os.kill(os.getpid(), signal.SIGINT)
            except KeyboardInterrupt:  # as a package does that takes it for a missing one
                return
            imported.append("package")
        imported.append("too late")

    with pytest.raises(KeyboardInterrupt):
        start()

    assert imported == ["package"]
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
