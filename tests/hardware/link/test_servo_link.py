from __future__ import annotations

import subprocess
import sys
import threading

import numpy as np
import pytest

from armtwin.hardware.emulator import FirmwareEmulator
from armtwin.hardware.emulator.noise import NoisyLine
from armtwin.hardware.link.framing import encode
from armtwin.hardware.link.messages import DetachReason, Request, Status
from armtwin.hardware.link.servo_link import (
    BoardResetError,
    LinkError,
    LinkLostError,
    RefusedError,
    ServoLink,
    WrongFirmwareError,
)
from armtwin.models.errors import InputError
from tests.support.scripted_board import HELLO, scripted_board

HOME = [1500.0, 1500.0, 1500.0]
PATIENCE_S = 10.0  # real time; only a failing test waits so long


def is_at(board: FirmwareEmulator, pulses_us: list[float]) -> bool:
    wanted = [*pulses_us, *[np.nan] * (6 - len(pulses_us))]
    return board.wait_until(
        lambda: bool(np.allclose(board.widths_us(), wanted, atol=0.5, rtol=0, equal_nan=True)), PATIENCE_S
    )


def is_limp(board: FirmwareEmulator) -> bool:
    return board.wait_until(lambda: bool(np.isnan(board.widths_us()).all()), PATIENCE_S)


def refusal(port: str, kind: type[InputError] = InputError, boot_timeout_s: float = 0.5) -> str:
    with pytest.raises(kind) as caught:
        ServoLink(port, boot_timeout_s=boot_timeout_s).connect()
    message = str(caught.value)
    assert "\n" not in message
    return message


def test_firmware_of_another_protocol_version_is_refused_with_the_remedy() -> None:
    with scripted_board(lambda payload: encode(bytes((0x81, payload[1], 0, 1)) + HELLO[1:])) as port:
        assert "speaks version 1 of the protocol, this program version 2; upload" in refusal(port, WrongFirmwareError)


def test_firmware_of_another_major_version_is_refused_with_the_remedy() -> None:
    newer = HELLO[:1] + b"\x03\x05" + HELLO[3:]
    with scripted_board(lambda payload: encode(bytes((0x81, payload[1], 0)) + newer)) as port:
        assert "its firmware is version 3.5, this program wants 2.x; upload" in refusal(port, WrongFirmwareError)


@pytest.mark.parametrize("n", [0, 7])
def test_more_servos_than_the_protocol_has_room_for_are_refused(n: int) -> None:
    many = HELLO[:3] + bytes((n,)) + HELLO[4:]
    with scripted_board(lambda payload: encode(bytes((0x81, payload[1], 0)) + many)) as port:
        assert f"drives {n} servos, 1 to 6 are wanted; upload" in refusal(port, WrongFirmwareError)


def test_how_many_servos_a_board_drives_is_taken_from_its_hello() -> None:
    two = HELLO[:3] + b"\x02" + HELLO[4:]
    with (
        scripted_board(lambda payload: encode(bytes((payload[0] | 0x80, payload[1], 0)) + two)) as port,
        ServoLink(port, keep_alive=False) as link,
        pytest.raises(InputError, match="drives 1 to 2 servos, 3 asked for"),
    ):
        link.arm(HOME)


def test_another_sketch_that_talks_is_told_from_silence() -> None:
    with scripted_board(lambda _: b"Hello, world!\r\n") as port:
        assert "bytes came, but no answer in armtwin's protocol; upload" in refusal(port)


def test_a_port_on_which_nothing_answers_is_refused_with_the_remedy() -> None:
    with scripted_board(lambda _: b"") as port:
        assert "nothing answered" in refusal(port)


def test_a_refused_port_is_free_again() -> None:
    with scripted_board(lambda _: b"") as port:
        assert refusal(port) == refusal(port)


def test_a_lost_answer_is_asked_for_again_under_the_same_number() -> None:
    heard: list[bytes] = []

    def answer(payload: bytes) -> bytes:
        heard.append(payload)
        if payload[0] == Request.HELLO:
            return encode(bytes((0x81, payload[1], 0)) + HELLO)
        return encode(bytes((payload[0] | 0x80, payload[1], 0))) if heard.count(payload) == 3 else b""

    with scripted_board(answer) as port, ServoLink(port, keep_alive=False) as link:
        link.arm(HOME)
        assert link.repeats == 2
    armings = [payload for payload in heard if payload[0] == Request.ARM]
    assert armings == [armings[0]] * 3


def test_an_answer_to_an_older_request_is_not_taken_for_this_ones() -> None:
    def answer(payload: bytes) -> bytes:
        if payload[0] == Request.HELLO:
            return encode(bytes((0x81, payload[1], 0)) + HELLO)
        old = encode(bytes((0x83, (payload[1] - 1) % 256, 0)) + b"\x01\x00")
        return old + encode(bytes((payload[0] | 0x80, payload[1], 0)) + b"\xe8\x03" * (payload[0] == Request.MOVE))

    with scripted_board(answer) as port, ServoLink(port, keep_alive=False) as link:
        assert link.move(HOME, 1.0) == 1.0


def test_a_board_that_falls_silent_is_given_up() -> None:
    def answer(payload: bytes) -> bytes:
        return encode(bytes((0x81, payload[1], 0)) + HELLO) if payload[0] == Request.HELLO else b""

    with (
        scripted_board(answer) as port,
        ServoLink(port, keep_alive=False) as link,
        pytest.raises(LinkError, match="no answer to ARM, sent 8 times"),
    ):
        link.arm(HOME)


def test_an_answer_without_sense_is_an_error_of_the_link() -> None:
    with (
        scripted_board(
            lambda payload: encode(bytes((payload[0] | 0x80, payload[1], 0)) + HELLO * (payload[0] == 1))
        ) as port,
        ServoLink(port, keep_alive=False) as link,
        pytest.raises(LinkError, match="makes no sense"),
    ):
        link.state()


def test_requests_before_connecting_say_so() -> None:
    with pytest.raises(LinkError, match="not connected"):
        ServoLink("/dev/null").state()


@pytest.mark.avr
def test_a_move_reaches_the_pins(board: FirmwareEmulator, link: ServoLink) -> None:
    link.arm(HOME)
    assert link.move([1600.0, 1400.0, 1500.5], 0.2) == 0.2
    assert link.wait().pulses_us == (1600.0, 1400.0, 1500.5)
    assert is_at(board, [1600.0, 1400.0, 1500.5])


@pytest.mark.avr
@pytest.mark.parametrize(
    ("pulses_us", "message"),
    [
        ([1500.0] * 7, "drives 1 to 6 servos, 7 asked for"),
        ([], "drives 1 to 6 servos, 0 asked for"),
        ([1500.0, 499.0, 1500.0], "pulse width of servo 2: 499.0 us is not between 500 and 2500 us"),
        ([1500.0, 1500.0, float("nan")], "pulse width of servo 3: nan us"),
    ],
)
def test_widths_that_the_board_would_refuse_are_not_sent(link: ServoLink, pulses_us: list[float], message: str) -> None:
    with pytest.raises(InputError, match=message):
        link.arm(pulses_us)
    assert not link.state().armed


@pytest.mark.avr
@pytest.mark.parametrize("end_us", [500.0, 2500.0])
def test_an_angle_at_the_servos_very_end_is_sent_whatever_its_last_digit(link: ServoLink, end_us: float) -> None:
    beyond_us = np.nextafter(end_us, end_us + (end_us - 1500.0))
    link.arm([beyond_us, 1500.0, 1500.0])
    assert link.state().pulses_us == (end_us, 1500.0, 1500.0)


@pytest.mark.avr
def test_a_move_of_a_minute_is_sent_whatever_its_last_digit(link: ServoLink) -> None:
    link.arm(HOME)
    assert link.move(HOME, np.nextafter(60.0, 61.0)) == 60.0


@pytest.mark.avr
@pytest.mark.parametrize("duration_s", [-0.1, 61.0, float("nan")])
def test_durations_that_the_board_would_refuse_are_not_sent(link: ServoLink, duration_s: float) -> None:
    link.arm(HOME)
    with pytest.raises(InputError, match="not between 0 and 60 s"):
        link.move(HOME, duration_s)


@pytest.mark.avr
def test_what_the_board_refuses_says_why(link: ServoLink) -> None:
    with pytest.raises(RefusedError, match="refused MOVE: NOT_ARMED") as caught:
        link.move(HOME, 0.1)
    assert caught.value.status is Status.NOT_ARMED


@pytest.mark.avr
def test_the_port_is_busy_for_a_second_program(board: FirmwareEmulator, link: ServoLink) -> None:
    assert "another program is using it" in refusal(board.port)
    assert not link.state().armed


@pytest.mark.avr
@pytest.mark.parametrize("error", [ValueError, KeyboardInterrupt])
def test_leaving_by_an_error_detaches(board: FirmwareEmulator, error: type[BaseException]) -> None:
    def break_off() -> None:
        with ServoLink(board.port) as link:
            link.arm(HOME)
            assert is_at(board, HOME)
            raise error

    with pytest.raises(error):
        break_off()
    end = board.time_s
    assert is_limp(board)
    assert board.time_s - end < 1.0  # not by the firmware's own two seconds


@pytest.mark.avr
def test_a_boot_loader_of_two_seconds_is_waited_for() -> None:
    with FirmwareEmulator(speed=2.0, boot_delay_s=2.0) as board, ServoLink(board.port) as link:
        assert link.hello().firmware_version == (2, 0)


@pytest.mark.avr
def test_an_idle_link_keeps_the_servos_armed(board: FirmwareEmulator, link: ServoLink) -> None:
    link.arm(HOME)
    end = board.time_s + 2 * link.hello().silence_timeout_s
    assert board.wait_until(lambda: board.time_s > end, PATIENCE_S)
    assert link.state().armed


@pytest.mark.avr
def test_without_keep_alive_the_board_detaches_by_itself(board: FirmwareEmulator) -> None:
    with ServoLink(board.port, keep_alive=False) as link:
        link.arm(HOME)
        assert is_at(board, HOME)
        assert is_limp(board)
        assert link.state().detach_reason is DetachReason.SILENCE


@pytest.mark.avr
def test_a_killed_host_leaves_limp_servos(board: FirmwareEmulator) -> None:
    program = (
        "import sys, time; from armtwin.hardware.link.servo_link import ServoLink\n"
        f"link = ServoLink({board.port!r}); link.connect(); link.arm({HOME}); time.sleep(60)"
    )
    host = subprocess.Popen([sys.executable, "-c", program])
    try:
        assert is_at(board, HOME)
    finally:
        host.kill()
        host.wait()
    assert is_limp(board)


@pytest.mark.avr
def test_unplugged_in_mid_move_it_says_so_and_can_go_on_after(board: FirmwareEmulator, link: ServoLink) -> None:
    link.arm(HOME)
    link.move([2000.0, 1500.0, 1500.0], 5.0)
    board.unplug()
    with pytest.raises(LinkLostError, match="lost"):
        link.state()
    assert is_limp(board)
    board.plug()
    link.reconnect()
    link.arm(HOME)
    link.move([1600.0, 1500.0, 1500.0], 0.1)
    assert is_at(board, [1600.0, 1500.0, 1500.0])


@pytest.mark.avr
def test_a_reset_board_says_so_and_can_go_on_after(board: FirmwareEmulator, link: ServoLink) -> None:
    link.arm(HOME)
    assert is_at(board, HOME)
    board.reset()
    assert is_limp(board)
    with pytest.raises(BoardResetError, match="was reset; its servos are detached"):
        link.move(HOME, 0.1)
    link.reconnect()
    link.arm(HOME)
    assert is_at(board, HOME)


@pytest.mark.avr
def test_reconnecting_in_vain_ends_with_the_reason(board: FirmwareEmulator, link: ServoLink) -> None:
    board.unplug()
    with pytest.raises(InputError, match="does not exist"):
        link.reconnect(timeout_s=0.3)


@pytest.mark.avr
def test_closing_a_link_whose_board_is_gone_is_no_error(board: FirmwareEmulator) -> None:
    link = ServoLink(board.port)
    link.connect()
    board.kill()
    link.close()
    link.close()


@pytest.mark.avr
def test_several_threads_share_a_link(link: ServoLink) -> None:
    link.arm(HOME)
    errors: list[LinkError] = []

    def ask() -> None:
        for _ in range(20):
            try:
                assert link.state().armed
            except LinkError as error:
                errors.append(error)

    threads = [threading.Thread(target=ask) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not errors


@pytest.mark.avr
def test_moves_get_through_a_line_that_loses_every_fifth_frame(board: FirmwareEmulator) -> None:
    with NoisyLine(board.port, seed=1, bad_frames=2, lost=0.2) as line, ServoLink(line.port) as link:
        link.arm(HOME)
        for pulse in np.linspace(1500.0, 1600.0, 20):
            link.move([pulse, 1500.0, 1500.0], 0.02)
        assert link.repeats > 0
        assert is_at(board, [1600.0, 1500.0, 1500.0])


@pytest.mark.avr
def test_wait_gives_up_on_a_move_that_takes_too_long(link: ServoLink) -> None:
    link.arm(HOME)
    link.move([1600.0, 1500.0, 1500.0], 60.0)
    with pytest.raises(LinkError, match="still moving"):
        link.wait(timeout_s=0.1)
    link.stop()
    assert not link.wait(timeout_s=0.1).moving
