from __future__ import annotations

import os
import select
import signal
import subprocess
import sys
import threading
import time
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from armtwin.hardware.emulator import FirmwareEmulator
from armtwin.hardware.link.ports import open_port
from armtwin.hardware.link.servo_link import ServoLink
from armtwin.models.errors import JobError

HOME = [1500.0, 1500.0, 1500.0]
PATIENCE_S = 10.0  # real time; only a failing test waits so long


@pytest.mark.avr
def test_opening_the_port_resets_the_board_once(board: FirmwareEmulator) -> None:
    before = board.resets
    with open_port(board.port, 0.1):
        assert board.wait_until(lambda: board.resets == before + 1, PATIENCE_S)
        other = os.open(board.port, os.O_RDWR | os.O_NOCTTY)
        end = board.time_s + 0.2
        assert board.wait_until(lambda: board.time_s > end, PATIENCE_S)
        os.close(other)
        assert board.resets == before + 1
    for again in range(2, 12):  # closed and opened at once
        with open_port(board.port, 0.1):
            assert board.wait_until(lambda wanted=before + again: board.resets == wanted, PATIENCE_S)


@pytest.mark.avr
def test_pulses_come_in_order_of_time_and_end_with_the_servos(board: FirmwareEmulator) -> None:
    with ServoLink(board.port) as link:
        link.arm([1400.0, 1500.0, 1600.0])
        assert board.wait_until(lambda: not np.isnan(board.widths_us()[:3]).any(), PATIENCE_S)
    pulses = list(board.pulses(timeout_s=0.5))
    assert len(pulses) >= 3
    assert [pulse.servo for pulse in pulses] == [index % 3 for index in range(len(pulses))]
    assert all(a.time_s < b.time_s for a, b in pairwise(pulses))
    np.testing.assert_allclose([pulse.width_us for pulse in pulses[:3]], [1400.0, 1500.0, 1600.0], atol=0.5)


@pytest.mark.avr
def test_the_port_vanishes_when_unplugged_and_returns_under_its_name(board: FirmwareEmulator) -> None:
    port = Path(board.port)
    assert port.exists()
    board.unplug()
    assert not port.exists()
    board.plug()
    assert port.exists()


@pytest.mark.avr
def test_time_stands_still_while_paused(board: FirmwareEmulator) -> None:
    board.pause()
    assert not board.wait_until(lambda: False, 0.1)  # lets the command arrive
    stopped = board.time_s
    assert not board.wait_until(lambda: board.time_s > stopped, 0.2)
    board.resume()
    assert board.wait_until(lambda: board.time_s > stopped, PATIENCE_S)


@pytest.mark.avr
def test_a_killed_board_sends_nothing_and_takes_no_command(board: FirmwareEmulator) -> None:
    board.kill()
    assert list(board.pulses(timeout_s=PATIENCE_S)) == []
    assert np.isnan(board.widths_us()).all()
    with pytest.raises(JobError, match="has ended"):
        board.reset()


@pytest.mark.avr
def test_it_does_not_outlive_the_program_that_started_it() -> None:
    program = (
        "import time; from armtwin.hardware.emulator import FirmwareEmulator\n"
        "board = FirmwareEmulator(); board.start(); print(board.port, flush=True); time.sleep(60)"
    )
    parent = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True)
    assert parent.stdout is not None
    with parent.stdout:
        port = Path(parent.stdout.readline().strip())
        device = port.resolve()
        children = Path(f"/proc/{parent.pid}/task/{parent.pid}/children").read_text().split()
        assert len(children) == 1
        assert device.exists()
        pidfd = os.pidfd_open(int(children[0]))
        try:
            parent.send_signal(signal.SIGKILL)
            parent.wait()
            ended, _, _ = select.select([pidfd], [], [], PATIENCE_S)
            assert ended
        finally:
            os.close(pidfd)


def test_a_board_that_was_not_started_has_no_port() -> None:
    with pytest.raises(JobError, match="not running"):
        _ = FirmwareEmulator().port


@pytest.mark.parametrize("speed", [0.0, -1.0, 1000.0, float("nan")])
def test_a_speed_out_of_range_is_refused(speed: float) -> None:
    with pytest.raises(ValueError, match="speed"):
        FirmwareEmulator(speed=speed)


@pytest.mark.avr
def test_emulated_time_stands_where_it_is_held_and_what_is_sent_meanwhile_is_heard_at_that_moment(
    board: FirmwareEmulator,
) -> None:
    with ServoLink(board.port) as link:
        link.arm(HOME)
        with link.quiet():
            stand_s = round(board.time_s + 0.1, 2)
            board.run_until(stand_s)
            assert board.time_s == pytest.approx(stand_s, abs=1e-4)
            board.drain()
            time.sleep(0.1)
            assert not board.drain()
            mover = threading.Thread(target=link.move, args=([1540.0, 1500.0, 1500.0], 0.0))
            mover.start()
            board.wait_for_bytes()
            board.run_until(stand_s + 0.06)
            mover.join(PATIENCE_S)
            widths = [pulse.width_us for pulse in board.drain() if pulse.servo == 0]
            assert widths[-1] == pytest.approx(1540.0, abs=1.0)
            board.run_free()
            assert board.wait_until(lambda: board.time_s > stand_s + 0.2, PATIENCE_S)
