"""Thousands of bad frames at both ends of the serial line: `python -m armtwin.hardware.emulator.fuzz --frames 10000`.

Three passes, each with its own promise; the first that is broken raises AssertionError with what was seen:

    limp    bad frames at a board that is not armed: no pulse, no reset, every good frame between them answered
    armed   the same at an armed board, and bursts of good frames faster than it can answer: every pulse on the way that
            was commanded, none faster than the slew limit
    link    bad frames both ways between ServoLink and the board, frames lost and doubled on top: every request done
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np
import serial

from armtwin.hardware.emulator.launcher import FirmwareEmulator, Pulse
from armtwin.hardware.emulator.noise import NoisyLine, bad_piece
from armtwin.hardware.link import messages
from armtwin.hardware.link.framing import DELIMITER, FrameReader, encode
from armtwin.hardware.link.messages import ANSWER, MOST_SERVOS, TICKS_PER_US, Request, Status
from armtwin.hardware.link.ports import open_port
from armtwin.hardware.link.servo_link import ServoLink

SPEED = 4.0  # times real time
BAD_IN_A_ROW = 8  # bad frames between two good ones, at most
BURST_FRAMES = 1500  # good ones without a pause: a second at line rate, twice the watchdog's patience
BURST_EVERY = 50  # moves
QUIET_S = 0.1  # real time without a byte, after which a question counts as lost
ANSWER_TIMEOUT_S = 2.0
WRITE_TIMEOUT_S = 20.0  # a burst is a second of emulated time, which a busy machine stretches
HOME_US = 1500.0
SPREAD_US = 300.0  # of the moves around home
CYCLE_US = 1 / 16  # of the processor: pulses are exact, the rest is rounding
SLEW_US = 40.0  # change of a width from one pulse to the next that protocol.md allows
UNKNOWN_TYPES = range(7, 128)


@dataclass
class Conversation:
    """Sends bad pieces and good requests to a board at `port`, and holds each answer against its request."""

    port: serial.Serial
    rng: np.random.Generator
    bad_sent: int = 0
    answered: int = 0
    sequence: int = 0

    def __post_init__(self) -> None:
        self.at_board = FrameReader()  # the state of an errorless receiver
        self.answers = FrameReader()

    def disturb(self) -> None:
        """Send one to eight bad pieces."""
        for _ in range(int(self.rng.integers(1, BAD_IN_A_ROW + 1))):
            piece = bad_piece(self.rng, self.at_board)
            self.at_board.feed(piece)
            self.port.write(piece)
            self.bad_sent += 1

    def burst(self) -> None:
        """Send many good frames without a look at the answers, then forget those.

        Some are lost, since an answer is longer than its request and the board's buffer is short.
        """
        self.sequence = (self.sequence + 1) % 256
        self.port.write(encode(messages.request(Request.STATE, self.sequence)) * BURST_FRAMES)
        self.sequence = catch_up(self.port, self.sequence + 1)

    def ask(self, kind: int, body: bytes = b"", *, twice: bool = False) -> tuple[Status, bytes]:
        """Send one good frame, or the same one twice; assert that each is answered, alike, and return the answer."""
        self.sequence = (self.sequence + 1) % 256
        frame = encode(bytes((kind, self.sequence)) + body) * (2 if twice else 1)
        self.at_board.feed(frame)
        self.port.write(frame)
        payloads: list[bytes] = []
        while len(payloads) < 1 + twice:
            data = self.port.read(1) + self.port.read(self.port.in_waiting)
            assert data, f"a good frame of type {kind} was not answered after {self.bad_sent} bad ones"
            payloads += self.answers.feed(data)
        assert payloads == [payloads[0]] * (1 + twice), f"answers {payloads} to one request"
        assert payloads[0][:2] == bytes((kind | ANSWER, self.sequence)), f"answer {payloads[0].hex()} to type {kind}"
        self.answered += len(payloads)
        _, _, status, rest = messages.split_answer(payloads[0])
        return status, rest

    def ask_nonsense(self) -> None:
        """Send a good frame whose content is none; assert that the board says so."""
        if self.rng.random() < 0.5:
            kind, wanted = int(self.rng.choice(UNKNOWN_TYPES)), Status.UNKNOWN_TYPE
        else:
            kind, wanted = int(self.rng.choice([Request.MOVE, Request.STATE])), Status.BAD_LENGTH
        body = self.rng.bytes(int(self.rng.integers(15, 30)))  # longer than any body
        status, _ = self.ask(kind, body)
        assert status is wanted, f"{status.name} to nonsense of type {kind}"


def fuzz_limp(frames: int, seed: int) -> str:
    """First pass of the module's docstring; returns a line about it."""
    with FirmwareEmulator(speed=SPEED) as board, greeted(board, seed) as talk:
        while talk.bad_sent < frames:
            talk.disturb()
            if talk.rng.random() < 0.3:
                talk.ask_nonsense()
            else:
                status, body = talk.ask(Request.STATE, twice=bool(talk.rng.random() < 0.2))
                assert status is Status.OK
                state = messages.parse_state(body)
                assert not state.armed
                assert state.bad_frames == talk.at_board.bad_frames % 65536, "board and host differ on what is bad"
        pulses = board.drain()
        assert not pulses, f"{len(pulses)} pulses from a board that was never armed"
        assert board.resets == 1, "the board was reset"
        return f"limp: {talk.bad_sent} bad frames, {talk.answered} good ones all answered, no pulse"


def fuzz_armed(frames: int, seed: int) -> str:
    """Second pass of the module's docstring; returns a line about it."""
    with FirmwareEmulator(speed=SPEED) as board, greeted(board, seed) as talk:
        status, _ = talk.ask(Request.ARM, messages.widths_body([round(HOME_US * TICKS_PER_US)] * MOST_SERVOS))
        assert status is Status.OK
        moves = 0
        pulses: list[Pulse] = []
        while talk.bad_sent < frames:
            talk.disturb()
            if moves % BURST_EVERY == 0:
                talk.burst()
            if talk.rng.random() < 0.3:
                talk.ask_nonsense()
            ticks = _random_ticks(talk.rng)
            status, _ = talk.ask(Request.MOVE, messages.move_body(100, ticks), twice=bool(talk.rng.random() < 0.2))
            assert status is Status.OK
            moves += 1
            pulses += board.drain()
        assert board.wait_until(lambda: _at(board, ticks), ANSWER_TIMEOUT_S), f"{board.widths_us()} after the last move"
        pulses += board.drain()
        assert board.resets == 1, "the board was reset"
        _check_pulses(pulses)
        return f"armed: {talk.bad_sent} bad frames, {moves} moves all answered, {len(pulses)} pulses, all as commanded"


def fuzz_link(frames: int, seed: int) -> str:
    """Third pass of the module's docstring; returns a line about it."""
    rng = np.random.default_rng(seed)
    with (
        FirmwareEmulator(speed=SPEED) as board,
        NoisyLine(board.port, seed=seed, bad_frames=BAD_IN_A_ROW, lost=0.02, repeated=0.1) as line,
        ServoLink(line.port) as link,
    ):
        link.arm([HOME_US] * MOST_SERVOS)
        requests = 0
        pulses: list[Pulse] = []
        while line.bad_to_board < frames or line.bad_to_host < frames:
            ticks = _random_ticks(rng)
            link.move(np.array(ticks) / TICKS_PER_US, 0.1)
            requests += 1
            pulses += board.drain()
        assert link.wait().armed
        assert board.wait_until(lambda: _at(board, ticks), ANSWER_TIMEOUT_S), f"{board.widths_us()} after the last move"
        pulses += board.drain()
        assert board.resets == 1, "the board was reset"
        _check_pulses(pulses)
        counts = f"{line.bad_to_board} bad frames to the board, {line.bad_to_host} to the host"
        return f"link: {counts}, {requests} moves all done, {link.repeats} requests sent again"


def catch_up(port: serial.Serial, sequence: int) -> int:
    """Forget what is still to come from the board: ask until the last question is answered, and return its number.

    Begins with `sequence`. A question behind a burst may be lost in the board's full buffer.
    """
    reader, patience_s = FrameReader(), port.timeout
    port.timeout = QUIET_S
    for number in range(sequence, sequence + 20):
        port.write(DELIMITER + encode(messages.request(Request.STATE, number % 256)))
        while data := port.read(port.in_waiting or 1):
            if any(payload[:2] == bytes((Request.STATE | ANSWER, number % 256)) for payload in reader.feed(data)):
                port.timeout = patience_s
                return number % 256
    raise AssertionError("the board does not answer behind a burst")


@contextmanager
def greeted(board: FirmwareEmulator, seed: int) -> Iterator[Conversation]:
    """A conversation with a board that has booted and was greeted."""
    hello = encode(messages.request(Request.HELLO, 0, bytes((messages.PROTOCOL_VERSION,))))
    with open_port(board.port, 0.1) as port:
        answered = False
        for _ in range(round(ANSWER_TIMEOUT_S / 0.1)):
            port.write(hello)
            if answered := bool(port.read(1)):
                break
        assert answered, "the board does not answer"
        while port.read(100):
            pass  # the rest of the hello
        port.timeout = ANSWER_TIMEOUT_S
        port.write_timeout = WRITE_TIMEOUT_S
        yield Conversation(port, np.random.default_rng(seed))


def _random_ticks(rng: np.random.Generator) -> list[int]:
    pulses_us = HOME_US + rng.uniform(-SPREAD_US, SPREAD_US, MOST_SERVOS)
    return [round(pulse * TICKS_PER_US) for pulse in pulses_us.tolist()]


def _at(board: FirmwareEmulator, ticks: list[int]) -> bool:
    wanted_us = np.array(ticks) / TICKS_PER_US
    return bool(np.all(np.abs(board.widths_us() - wanted_us) <= CYCLE_US))  # false for a limp servo


def _check_pulses(pulses: list[Pulse]) -> None:
    """Assert that no servo missed a pulse, left the range of the commanded widths, or went faster than it may."""
    assert pulses, "an armed board sent no pulse"
    for servo in range(MOST_SERVOS):
        widths = np.array([pulse.width_us for pulse in pulses if pulse.servo == servo])
        rises_s = np.array([pulse.time_s - pulse.width_us * 1e-6 for pulse in pulses if pulse.servo == servo])
        far = np.abs(widths - HOME_US).max()
        assert far <= SPREAD_US + CYCLE_US, f"servo {servo + 1}: a pulse {far} us from home"
        step = np.abs(np.diff(widths)).max(initial=0.0)
        assert step <= SLEW_US + CYCLE_US, f"servo {servo + 1}: a step of {step} us"
        late_us = np.abs(np.diff(rises_s) - 0.02).max(initial=0.0) * 1e6
        assert late_us < CYCLE_US, f"servo {servo + 1}: a pulse {late_us} us off its period"


def main() -> None:
    """Run the three passes with the numbers of the command line."""
    parser = argparse.ArgumentParser(description="Bad frames at both ends of the serial line to the emulated board.")
    parser.add_argument("--frames", type=int, default=10_000, help="bad frames in each pass and direction")
    parser.add_argument("--seed", type=int, default=0)
    arguments = parser.parse_args()
    for fuzz in (fuzz_limp, fuzz_armed, fuzz_link):
        print(fuzz(arguments.frames, arguments.seed), flush=True)


if __name__ == "__main__":
    main()
