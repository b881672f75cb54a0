"""The servo board behind its serial port, as the rest of the bench sees it.

    with ServoLink("/dev/ttyACM0") as link:          # opens, waits for the board to boot, says hello
        link.arm([1500.0, 1500.0, 1500.0])           # pulses begin at these widths, us, one a servo
        link.move([1600.0, 1500.0, 1400.0], 0.5)     # acknowledged at once, executed over 0.5 s
        link.wait()                                  # until the board has sent the last width
                                                     # leaving detaches the servos, also on an exception or Ctrl-C

A request keeps its sequence number when it is sent again because no answer came; the board executes a number once and
only repeats its answer after that:

    host    MOVE 7 -------------> MOVE 7 -----------> MOVE 8 ------->
    board          moves; OK 7           OK 7                moves; OK 8
                   (answer lost)         (no new move)

A board that hears nothing for `Hello.silence_timeout_s` (2 s) detaches its servos. A thread of the link therefore asks
for its state a few times in that while, so slow work between two moves needs no care; if the program dies, the thread
dies with it and the board detaches.
"""

from __future__ import annotations

import contextlib
import threading
import time
from collections.abc import Callable, Iterator
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike

from armtwin.hardware.link import messages
from armtwin.hardware.link.exchange import BoardResetError, Exchange, LinkError, LinkLostError, RefusedError
from armtwin.hardware.link.messages import MAX_DURATION_S, BoardState, Hello, Request
from armtwin.models.errors import InputError

__all__ = [
    "BoardResetError",
    "BoardState",
    "Hello",
    "LinkError",
    "LinkLostError",
    "RefusedError",
    "ServoLink",
    "WrongFirmwareError",
]

BOOT_TIMEOUT_S = 5.0  # an Uno's boot loader holds the sketch back for up to 2 s after the port is opened
KEEP_ALIVE_SHARE = 8  # the board is asked this many times in the silence that it tolerates
STATE_PERIOD_S = 0.02  # one period of the servo pulses: the state changes no faster
REOPEN_PERIOD_S = 0.1  # a USB port takes about a second to come back
FIRMWARE_HINT = "upload hardware/firmware/armtwin_firmware to it (with the Arduino IDE, or make upload PORT=...)"


T = TypeVar("T")


class WrongFirmwareError(InputError):
    """A board answers, with another firmware than this program's; the message says how to get the right one there."""


class ServoLink:
    """Serial link to the firmware of `hardware/firmware`; safe to use from several threads.

    Every request may raise LinkError (no answer) or its kinds: LinkLostError (port gone), BoardResetError (the board
    has booted), RefusedError (its `status` says why, for example NOT_ARMED after the board detached by itself).
    """

    def __init__(self, port: str, *, boot_timeout_s: float = BOOT_TIMEOUT_S, keep_alive: bool = True) -> None:
        """Note the arguments; `connect` opens the port. Without `keep_alive` the caller must ask often enough himself.

        Nothing is sent, and an Uno is not reset, before `connect`.
        """
        self.port = port
        self._boot_timeout_s = boot_timeout_s
        self._keep_alive = keep_alive
        self._lock = threading.RLock()
        self._exchange: Exchange | None = None
        self._quiet = False
        self._hello: Hello | None = None
        self._closing = threading.Event()
        self._thread: threading.Thread | None = None

    def connect(self) -> Hello:
        """Open the port, wait until the board has booted, check its firmware; a board that was armed detaches.

        Raises InputError for a port that is missing, forbidden or busy, or that nothing answers on; its kind
        WrongFirmwareError for a board with another firmware or protocol version.
        """
        with self._lock:
            self._drop_port()
            exchange = Exchange(self.port)
            try:
                self._hello = _wait_for_hello(exchange, self._boot_timeout_s)
            except BaseException:  # also Ctrl-C while it boots: the port must not stay locked
                exchange.close()
                raise
            self._exchange = exchange
            if self._keep_alive and self._thread is None:
                self._start_keep_alive(self._hello.silence_timeout_s / KEEP_ALIVE_SHARE)
            return self._hello

    def reconnect(self, timeout_s: float = 10.0) -> Hello:
        """Close the port and open it again, waiting up to `timeout_s` for it to come back; the servos are detached.

        For programs that go on over a reset or a loose plug, as after LinkLostError and BoardResetError. A capture does
        not: where a limp arm fell to is for its next start to see, which takes the recording up behind its last pose.
        Raises InputError, as `connect` does, if it cannot be opened in that time.
        """
        deadline = time.monotonic() + timeout_s
        while True:
            try:
                return self.connect()
            except InputError:
                if time.monotonic() > deadline:
                    raise
            time.sleep(REOPEN_PERIOD_S)

    def hello(self) -> Hello:
        """What the board said of itself when it was connected; raises LinkError before `connect`."""
        if self._hello is None:
            raise LinkError(f"serial port {self.port}: not connected")
        return self._hello

    def arm(self, pulses_us: ArrayLike) -> None:
        """Begin to send pulses of these widths, us, (n,) on servos 1 to n: the place where the arm is believed to be.

        A servo that is elsewhere jumps there, which no firmware can prevent: hobby servos report no position. Raises
        InputError for widths that the board would refuse, RefusedError (ALREADY_ARMED) if it is armed.
        """
        ticks = self._ticks(pulses_us)
        most = self.hello().n_servos
        if not 1 <= len(ticks) <= most:
            raise InputError(
                f"pulse widths: the board at {self.port} drives 1 to {most} servos, {len(ticks)} asked for"
            )
        self._ask(Request.ARM, messages.widths_body(ticks))

    def move(self, pulses_us: ArrayLike, duration_s: float) -> float:
        """Move to these widths, us, one a servo that is armed, along one straight line; return the seconds it takes.

        Returns once the board has acknowledged. The board takes longer than `duration_s` (0 to 60) where its slew limit
        demands it. Raises InputError for widths or a duration that the board would refuse.
        """
        duration_ms = np.rint(duration_s * 1000)  # first: a minute that floats missed by their last digit is one
        if not 0.0 <= duration_ms <= MAX_DURATION_S * 1000:  # false for NaN
            raise InputError(f"duration of a move: {duration_s} s is not between 0 and {MAX_DURATION_S:.0f} s")
        body = messages.move_body(int(duration_ms), self._ticks(pulses_us))
        return self._parsed(messages.parse_duration, self._ask(Request.MOVE, body))

    @contextlib.contextmanager
    def quiet(self) -> Iterator[None]:
        """Say nothing of its own within the block; the caller has to speak more often than the board is silent."""
        self._quiet = True
        try:
            yield
        finally:
            self._quiet = False

    def state(self) -> BoardState:
        """Ask for the state of the board: armed, moving, why it detached, the widths it sends."""
        return self._parsed(messages.parse_state, self._ask(Request.STATE))

    def wait(self, timeout_s: float = MAX_DURATION_S + 1.0) -> BoardState:
        """Wait until no move is under way and return the state then; raises LinkError after `timeout_s`."""
        deadline = time.monotonic() + timeout_s
        while (state := self.state()).moving:
            if time.monotonic() > deadline:
                raise LinkError(f"serial port {self.port}: still moving after {timeout_s:.1f} s")
            time.sleep(STATE_PERIOD_S)
        return state

    def stop(self) -> None:
        """Hold the servos where they are in the midst of a move; they stay armed.

        For programs that break a move off and go on. A capture that is broken off detaches them, as `close` does.
        """
        self._ask(Request.STOP)

    def detach(self) -> None:
        """Send no more pulses: the servos go limp."""
        self._ask(Request.DETACH)

    def close(self) -> None:
        """Detach if the board still answers, and close the port. May be called twice."""
        self._closing.set()
        with self._lock:
            if self._exchange is not None:
                with contextlib.suppress(LinkError):  # a lost board hears nothing any more and detaches by itself
                    self.detach()
            self._drop_port()
            self._hello = None
        if self._thread is not None:
            self._thread.join()
            self._thread = None

    def __enter__(self) -> ServoLink:
        self.connect()
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @property
    def repeats(self) -> int:
        """Requests that had to be sent again since the port was opened."""
        return 0 if self._exchange is None else self._exchange.repeats

    def _ask(self, kind: Request, body: bytes = b"") -> bytes:
        with self._lock:
            if self._exchange is None:
                raise LinkError(f"serial port {self.port}: not connected")
            return self._exchange.ask(kind, body)

    def _parsed(self, parse: Callable[[bytes], T], body: bytes) -> T:
        try:
            return parse(body)
        except messages.MessageError as error:
            raise LinkError(f"serial port {self.port}: the board's answer makes no sense: {error}") from None

    def _ticks(self, pulses_us: ArrayLike) -> list[int]:
        hello = self.hello()
        pulses = np.asarray(pulses_us, dtype=np.float64)
        if pulses.ndim != 1:
            raise InputError(f"pulse widths: one a servo is wanted, got shape {pulses.shape}")
        ticks = np.rint(
            pulses * messages.TICKS_PER_US
        )  # first: an angle at the servo's very end may miss it by 1e-13 us
        sent_us = ticks / messages.TICKS_PER_US
        good = (sent_us >= hello.min_pulse_us) & (sent_us <= hello.max_pulse_us)  # false for NaN
        if not good.all():
            servo = int(np.argmin(good))
            raise InputError(
                f"pulse width of servo {servo + 1}: {pulses[servo]} us is not between "
                f"{hello.min_pulse_us:.0f} and {hello.max_pulse_us:.0f} us"
            )
        return [int(tick) for tick in ticks]

    def _start_keep_alive(self, period_s: float) -> None:
        self._closing.clear()
        self._thread = threading.Thread(target=self._stay_alive, args=(period_s,), name="servo-link", daemon=True)
        self._thread.start()

    def _stay_alive(self, period_s: float) -> None:
        while not self._closing.wait(period_s):
            if self._quiet:
                continue
            with contextlib.suppress(LinkError):  # the caller's next request meets the same error
                self.state()

    def _drop_port(self) -> None:
        if self._exchange is not None:
            self._exchange.close()
            self._exchange = None


def _wait_for_hello(exchange: Exchange, timeout_s: float) -> Hello:
    """Ask until the board has booted and answers; raises InputError if none answers, WrongFirmwareError."""
    deadline = time.monotonic() + timeout_s
    while time.monotonic() < deadline:
        try:
            body = exchange.ask(Request.HELLO, bytes((messages.PROTOCOL_VERSION,)), attempts=1)
        except LinkLostError:
            raise
        except LinkError:
            continue
        return _checked_hello(exchange.port, body)
    port, heard = f"serial port {exchange.port}", exchange.bytes_heard
    if heard:
        raise InputError(f"{port}: {heard} bytes came, but no answer in armtwin's protocol; {FIRMWARE_HINT}")
    raise InputError(f"{port}: nothing answered in {timeout_s:.0f} s; if this is the Arduino's port, {FIRMWARE_HINT}")


def _checked_hello(port: str, body: bytes) -> Hello:
    if not body or body[0] != messages.PROTOCOL_VERSION:
        found = f"version {body[0]}" if body else "no version"
        raise WrongFirmwareError(
            f"serial port {port}: its firmware speaks {found} of the protocol, this program version "
            f"{messages.PROTOCOL_VERSION}; {FIRMWARE_HINT}"
        )
    try:
        hello = messages.parse_hello(body)
    except messages.MessageError as error:
        raise WrongFirmwareError(
            f"serial port {port}: its firmware's hello makes no sense ({error}); {FIRMWARE_HINT}"
        ) from None
    major, minor = hello.firmware_version
    if major != messages.FIRMWARE_MAJOR:
        raise WrongFirmwareError(
            f"serial port {port}: its firmware is version {major}.{minor}, this program wants "
            f"{messages.FIRMWARE_MAJOR}.x; {FIRMWARE_HINT}"
        )
    if not 1 <= hello.n_servos <= messages.MOST_SERVOS:
        raise WrongFirmwareError(
            f"serial port {port}: its firmware drives {hello.n_servos} servos, 1 to {messages.MOST_SERVOS} are wanted; "
            f"{FIRMWARE_HINT}"
        )
    return hello
