"""The built firmware in the emulator, spoken to byte by byte: what the board does whatever a host does."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import serial

from armtwin.hardware.emulator import FirmwareEmulator, Pulse, build
from armtwin.hardware.emulator.fuzz import catch_up
from armtwin.hardware.link import messages
from armtwin.hardware.link.framing import FrameReader, decode, encode
from armtwin.hardware.link.messages import DetachReason, Request, Status
from armtwin.hardware.link.ports import open_port

pytestmark = pytest.mark.avr

PROTOCOL = Path(messages.__file__).with_name("protocol.md")
TICK_US = 0.5
CYCLE_US = 1 / 16  # of the processor
FLOOD_S = 1.5  # of emulated time: three times the watchdog's patience
BYTE_S = 10 / 115200  # 8N1
SPEED = 4.0  # times real time
PATIENCE_S = 5.0  # real time; only a failing test waits so long


class Wire:
    """Sends payloads with the sequence numbers of the test's choice."""

    def __init__(self, port: serial.Serial) -> None:
        self._port = port
        self._reader = FrameReader()

    def send(self, data: bytes) -> bytes:
        """Send bytes, return those of the next answer as they came; empty if none comes."""
        self._port.write(data)
        heard = b""
        while byte := self._port.read(1):
            heard += byte
            if byte == b"\0" and len(heard) > 1:
                break
        return heard

    def ask(self, kind: int, sequence: int, body: bytes = b"") -> tuple[Status, bytes]:
        answer = self.send(encode(bytes((kind, sequence)) + body))
        _, answered, status, rest = messages.split_answer(decode(answer[1:-1]))
        assert answered == sequence
        return status, rest

    def flood(self, kind: int, sequence: int) -> None:
        """Send the same frame again and again for `FLOOD_S`, without a look at the answers."""
        frame = encode(bytes((kind, sequence)))
        self._port.write_timeout = PATIENCE_S
        self._port.write(frame * round(FLOOD_S / BYTE_S / len(frame)))

    def hello(self) -> None:
        assert self.ask(Request.HELLO, 0, b"\x02")[0] is Status.OK

    def arm(self, pulses_us: tuple[float, ...] = (1500.0, 1500.0, 1500.0), sequence: int = 1) -> Status:
        return self.ask(Request.ARM, sequence, messages.widths_body(ticks(pulses_us)))[0]

    def move(self, sequence: int, pulses_us: tuple[float, ...], duration_ms: int = 0) -> tuple[Status, bytes]:
        return self.ask(Request.MOVE, sequence, messages.move_body(duration_ms, ticks(pulses_us)))

    def state(self, sequence: int) -> messages.BoardState:
        return messages.parse_state(self.ask(Request.STATE, sequence)[1])


def ticks(pulses_us: tuple[float, ...]) -> list[int]:
    return [round(pulse / TICK_US) for pulse in pulses_us]


def in_cycles(time_us: float) -> int:
    return round(time_us / CYCLE_US)


def widths(pulses: list[Pulse], servo: int) -> np.ndarray:
    return np.array([pulse.width_us for pulse in pulses if pulse.servo == servo])


def is_at(board: FirmwareEmulator, pulses_us: tuple[float, ...]) -> bool:
    wanted = [*pulses_us, *[np.nan] * (6 - len(pulses_us))]
    return board.wait_until(
        lambda: bool(np.allclose(board.widths_us(), wanted, atol=CYCLE_US, rtol=0, equal_nan=True)), PATIENCE_S
    )


def is_limp(board: FirmwareEmulator) -> bool:
    return board.wait_until(lambda: bool(np.isnan(board.widths_us()).all()), PATIENCE_S)


def run(board: FirmwareEmulator, seconds: float) -> None:
    end = board.time_s + seconds
    assert board.wait_until(lambda: board.time_s >= end, PATIENCE_S)


def start(board: FirmwareEmulator, wire: Wire, pulses_us: tuple[float, ...] = (1500.0, 1500.0, 1500.0)) -> None:
    wire.hello()
    assert wire.arm(pulses_us) is Status.OK
    assert is_at(board, pulses_us)


@pytest.fixture
def wire(board: FirmwareEmulator) -> Iterator[Wire]:
    with open_port(board.port, 1.0) as port:
        run(board, 0.3)  # the boot loader
        yield Wire(port)


def examples() -> list[tuple[str, bytes, bytes]]:
    rows = [line.split("|") for line in PROTOCOL.read_text(encoding="utf-8").splitlines() if line.startswith("|")]
    cells = [[cell.strip().strip("`") for cell in row[1:4]] for row in rows]
    return [(who, bytes.fromhex(a), bytes.fromhex(b)) for who, a, b in cells if who in ("host", "board")]


def test_the_protocol_page_has_an_example_of_every_request() -> None:
    assert {payload[0] for who, payload, _ in examples() if who == "host"} >= {int(kind) for kind in Request}


@pytest.mark.parametrize(("payload", "on_the_wire"), [(a, b) for _, a, b in examples()])
def test_examples_of_the_protocol_page_are_what_the_host_sends_and_reads(payload: bytes, on_the_wire: bytes) -> None:
    assert encode(payload) == on_the_wire
    assert FrameReader().feed(on_the_wire) == [payload]


def test_the_board_answers_the_conversation_of_the_protocol_page_byte_for_byte(wire: Wire) -> None:
    conversation = examples()
    assert [who for who, _, _ in conversation] == ["host", "board"] * (len(conversation) // 2)
    for (_, _, question), (_, _, answer) in zip(conversation[::2], conversation[1::2], strict=True):
        assert wire.send(question).hex(" ") == answer.hex(" ")


def test_it_boots_without_pulses(board: FirmwareEmulator) -> None:
    run(board, 1.0)
    assert board.drain() == []


def test_a_greeting_and_refused_requests_start_no_pulses(board: FirmwareEmulator, wire: Wire) -> None:
    assert wire.arm() is Status.NO_HELLO
    wire.hello()
    assert wire.move(1, (1600.0, 1600.0, 1600.0))[0] is Status.NOT_ARMED
    assert wire.arm((400.0, 1500.0, 1500.0), sequence=2) is Status.BAD_WIDTH
    run(board, 0.5)
    assert board.drain() == []


@pytest.mark.parametrize("n_servos", [1, 2, 3, 4, 5, 6])
@pytest.mark.parametrize("first_us", [500.0, 1027.0, 1500.5, 2500.0])
def test_pulses_are_as_long_as_asked_to_the_cycle_and_come_every_20_ms(
    board: FirmwareEmulator, wire: Wire, first_us: float, n_servos: int
) -> None:
    # Edges in every phase of the instructions around them.
    pulses_us = (first_us, 3000.0 - first_us, 1234.5, 763.5, 2500.0, 1999.0)[:n_servos]
    wire.hello()
    wire.arm(pulses_us)
    run(board, 0.5)
    pulses = board.drain()
    assert {pulse.servo for pulse in pulses} == set(range(n_servos))
    for servo, wanted in enumerate(pulses_us):
        mine = [(in_cycles(pulse.time_s * 1e6), in_cycles(pulse.width_us)) for pulse in pulses if pulse.servo == servo]
        assert len(mine) > 20
        assert {width for _, width in mine} == {in_cycles(wanted)}
        assert set(np.diff([end - width for end, width in mine])) == {in_cycles(20_000.0)}


def test_pulses_keep_their_length_while_the_line_is_busy(board: FirmwareEmulator, wire: Wire) -> None:
    start(board, wire)
    for sequence in range(2, 100):
        wire._port.write(b"\xff" * 40 + b"\0")  # every byte an interrupt
        wire.state(sequence)
    pulses = board.drain()
    assert len(pulses) > 30
    assert {in_cycles(pulse.width_us) for pulse in pulses} == {in_cycles(1500.0)}


@pytest.mark.parametrize("reading", [True, False], ids=["answers-read", "answers-unread"])
@pytest.mark.parametrize("n_servos", [3, 6])
def test_good_frames_at_line_rate_neither_reset_it_nor_touch_a_pulse(
    board: FirmwareEmulator, wire: Wire, reading: bool, n_servos: int
) -> None:
    """Answers are three times as long as what asks for them, so that the board's line is never idle."""
    home = (1500.0,) * n_servos
    start(board, wire, home)
    wire.flood(Request.STATE, 2)
    if not reading:
        run(board, FLOOD_S)
    catch_up(wire._port, 100)
    assert board.resets == 1
    pulses = board.drain()
    assert len(pulses) > n_servos * FLOOD_S / 0.02
    for servo in range(n_servos):
        mine = [pulse for pulse in pulses if pulse.servo == servo]
        assert {in_cycles(pulse.width_us) for pulse in mine} == {in_cycles(1500.0)}
        assert set(np.diff([in_cycles(pulse.time_s * 1e6) for pulse in mine])) == {in_cycles(20_000.0)}
    assert wire.move(3, (1600.0, *home[1:]))[0] is Status.OK
    assert is_at(board, (1600.0, *home[1:]))


def test_six_servos_take_each_step_of_a_move_together_on_a_busy_line(board: FirmwareEmulator, wire: Wire) -> None:
    start(board, wire, (1500.0,) * 6)
    wire.move(2, (1600.0,) * 6, 1000)
    wire.flood(Request.STATE, 3)
    run(board, FLOOD_S)
    pulses = board.drain()
    way = np.stack([widths(pulses, servo)[-60:] for servo in range(6)])
    assert np.ptp(way, axis=0).max() <= CYCLE_US
    assert abs(way[0, -1] - 1600.0) <= CYCLE_US


def test_a_move_goes_on_in_equal_steps_while_good_frames_come_at_line_rate(board: FirmwareEmulator, wire: Wire) -> None:
    start(board, wire)
    wire.move(2, (1600.0, 1500.0, 1500.0), 1000)
    wire.flood(Request.STATE, 3)
    run(board, FLOOD_S)
    way = widths(board.drain(), 0)
    assert abs(way[-1] - 1600.0) <= CYCLE_US
    assert np.diff(way).max() <= 2.0 + CYCLE_US  # 100 us in 50 periods of 20 ms


def test_silence_after_frames_at_line_rate_detaches(board: FirmwareEmulator, wire: Wire) -> None:
    start(board, wire)
    wire.flood(Request.STATE, 2)
    assert is_limp(board)
    catch_up(wire._port, 100)
    assert wire.state(3).detach_reason is DetachReason.SILENCE


@pytest.mark.parametrize("wrong", [499.5, 2500.5, 0.0, 32767.5])
def test_a_width_out_of_range_is_refused_and_nothing_moves(board: FirmwareEmulator, wire: Wire, wrong: float) -> None:
    start(board, wire)
    assert wire.move(2, (1600.0, wrong, 1600.0))[0] is Status.BAD_WIDTH
    run(board, 0.2)
    assert {round(width) for width in widths(board.drain(), 0)} == {1500}


def test_a_duration_above_a_minute_is_refused(wire: Wire) -> None:
    wire.hello()
    wire.arm()
    assert wire.move(2, (1600.0, 1600.0, 1600.0), 60_001)[0] is Status.BAD_DURATION


def test_a_move_goes_in_equal_steps_over_its_duration(board: FirmwareEmulator, wire: Wire) -> None:
    start(board, wire)
    status, body = wire.move(2, (1600.0, 1500.0, 1450.0), 400)
    assert status is Status.OK
    assert messages.parse_duration(body) == 0.4
    assert is_at(board, (1600.0, 1500.0, 1450.0))
    pulses = board.drain()
    for servo, step in enumerate((5.0, 0.0, -2.5)):
        way = widths(pulses, servo)
        way = way[np.flatnonzero(np.abs(way - 1500.0) <= CYCLE_US)[0 if step == 0 else -1] :]
        expected = 1500.0 + step * np.minimum(np.arange(len(way)), 20)
        assert np.abs(way - expected).max() <= CYCLE_US


def test_a_move_too_fast_is_stretched_to_the_slew_limit(board: FirmwareEmulator, wire: Wire) -> None:
    start(board, wire, (600.0, 1500.0, 1500.0))
    _, body = wire.move(2, (2400.0, 1600.0, 1500.0), 0)
    assert messages.parse_duration(body) == pytest.approx(1800.0 / 2000.0)
    assert is_at(board, (2400.0, 1600.0, 1500.0))
    assert np.abs(np.diff(widths(board.drain(), 0))).max() <= 40.0 + CYCLE_US


def test_a_move_in_the_midst_of_another_goes_on_from_where_it_is(board: FirmwareEmulator, wire: Wire) -> None:
    start(board, wire)
    wire.move(2, (2000.0, 1500.0, 1500.0), 1000)
    run(board, 0.4)
    wire.move(3, (1000.0, 1500.0, 1500.0), 0)
    assert is_at(board, (1000.0, 1500.0, 1500.0))
    assert np.abs(np.diff(widths(board.drain(), 0))).max() <= 40.0 + CYCLE_US


def test_stop_holds_where_the_move_is(board: FirmwareEmulator, wire: Wire) -> None:
    start(board, wire)
    wire.move(2, (2000.0, 1500.0, 1500.0), 1000)
    run(board, 0.4)
    wire.ask(Request.STOP, 3)
    state = wire.state(4)
    assert state.armed
    assert not state.moving
    assert 1500.0 < state.pulses_us[0] < 2000.0
    assert is_at(board, state.pulses_us)
    board.drain()
    run(board, 0.3)
    assert np.abs(widths(board.drain(), 0) - state.pulses_us[0]).max() <= CYCLE_US


@pytest.mark.parametrize("phase", range(6))
def test_detach_ends_the_pulses_and_cuts_none(board: FirmwareEmulator, wire: Wire, phase: int) -> None:
    start(board, wire, (2500.0, 2500.0, 2500.0))
    run(board, 0.1 + phase * 0.0033)
    wire.ask(Request.DETACH, 2)
    assert is_limp(board)
    assert all(abs(pulse.width_us - 2500.0) <= CYCLE_US for pulse in board.drain())
    state = wire.state(3)
    assert (state.armed, state.detach_reason) == (False, DetachReason.COMMAND)
    run(board, 0.3)
    board.reset()  # a pin left high would end its pulse here
    run(board, 0.1)
    assert board.drain() == []


def test_a_silent_host_is_detached_after_two_seconds(board: FirmwareEmulator, wire: Wire) -> None:
    start(board, wire)
    assert is_limp(board)
    pulses = board.drain()
    assert pulses[-1].time_s - pulses[0].time_s == pytest.approx(2.0, abs=0.05)
    assert wire.state(2).detach_reason is DetachReason.SILENCE


def test_noise_does_not_count_as_a_host(board: FirmwareEmulator, wire: Wire) -> None:
    start(board, wire)
    end = board.time_s + 3.0
    port = wire._port
    while board.time_s < end:
        port.write(b"\x05noise\0")
        run(board, 0.05)
    assert is_limp(board)


def test_another_hello_detaches(board: FirmwareEmulator, wire: Wire) -> None:
    start(board, wire)
    wire.hello()
    assert is_limp(board)
    assert wire.state(1).detach_reason is DetachReason.HELLO


@pytest.mark.parametrize("n_servos", [0, 7])
def test_no_servo_and_a_seventh_are_refused(wire: Wire, n_servos: int) -> None:
    wire.hello()
    assert wire.arm((1500.0,) * n_servos) is Status.BAD_LENGTH


def test_a_move_of_other_servos_than_were_armed_is_refused(board: FirmwareEmulator, wire: Wire) -> None:
    start(board, wire, (1500.0, 1500.0))
    assert wire.move(2, (1600.0, 1600.0, 1600.0))[0] is Status.BAD_LENGTH
    assert wire.state(3).pulses_us == (1500.0, 1500.0)


def test_an_armed_board_is_not_armed_elsewhere(wire: Wire) -> None:
    wire.hello()
    wire.arm()
    assert wire.arm((2000.0, 1500.0, 1500.0), sequence=2) is Status.ALREADY_ARMED


def test_a_repeated_move_is_acknowledged_and_not_executed_twice(board: FirmwareEmulator, wire: Wire) -> None:
    start(board, wire)
    first = wire.move(2, (1600.0, 1500.0, 1500.0), 1000)
    for _ in range(5):
        run(board, 0.15)
        assert wire.move(2, (1600.0, 1500.0, 1500.0), 1000) == first
    assert is_at(board, (1600.0, 1500.0, 1500.0))
    on_the_way = widths(board.drain(), 0)
    on_the_way = on_the_way[(on_the_way > 1501.0) & (on_the_way < 1599.0)]
    assert len(on_the_way) == 49  # steps of 2 us each 20 ms: a move begun anew would take more


def test_a_hello_forgets_the_number_before_it(wire: Wire) -> None:
    wire.hello()
    assert wire.arm(sequence=0) is Status.OK
    assert wire.state(1).armed


def test_its_own_answers_come_back_unanswered(wire: Wire) -> None:
    wire.hello()
    wire._port.timeout = 0.2
    assert wire.send(encode(b"\x84\x01\x00")) == b""


@pytest.mark.parametrize("kind", list(Request))
def test_a_body_of_a_wrong_length_is_refused(wire: Wire, kind: Request) -> None:
    wire.hello()
    if kind is not Request.ARM:
        wire.arm()
    assert wire.ask(kind, 9, b"012345678")[0] is Status.BAD_LENGTH


def test_a_program_that_hangs_is_reset_by_the_watchdog(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    sketch = tmp_path / "sketch"
    shutil.copytree(build.FIRMWARE, sketch)
    source = sketch / "armtwin_firmware.ino"
    healthy = source.read_text(encoding="utf-8")
    hanging = healthy.replace("if (type == DETACH) detach(COMMAND);", "if (type == STOP) for (;;) {}")
    assert hanging != healthy
    source.write_text(hanging, encoding="utf-8")
    monkeypatch.setattr(build, "FIRMWARE", sketch)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    with FirmwareEmulator(speed=SPEED) as board, open_port(board.port, 1.0) as port:
        run(board, 0.3)
        wire = Wire(port)
        start(board, wire)
        hung_s = board.time_s
        port.write(encode(bytes((Request.STOP, 2))))
        assert is_limp(board)
        assert board.time_s - hung_s < 1.0  # not by the two seconds of silence, which a hanging program does not count
        run(board, 0.3)
        wire.hello()
        assert not wire.state(1).armed


def test_a_reset_detaches_and_is_told_to_the_next_request(board: FirmwareEmulator, wire: Wire) -> None:
    start(board, wire)
    board.reset()
    assert is_limp(board)
    run(board, 0.3)
    assert wire.ask(Request.MOVE, 2, messages.move_body(0, [3000] * 3))[0] is Status.NO_HELLO
