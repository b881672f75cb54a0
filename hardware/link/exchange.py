"""One request and its answer over an open serial port, with retries by sequence number."""

from __future__ import annotations

import time

import serial

from armtwin.hardware.link import framing, messages
from armtwin.hardware.link.messages import Request, Status
from armtwin.hardware.link.ports import open_port
from armtwin.models.errors import JobError

POLL_S = 0.02  # a read returns at the latest after this; an answer wakes it earlier
ANSWER_TIMEOUT_S = 0.1  # wait before a request is sent again; an answer takes about 3 ms at 115200 baud
ATTEMPTS = 8  # times that a request is sent before the link counts as broken


class LinkError(JobError):
    """The board did not answer, or not as it should."""


class LinkLostError(LinkError):
    """The port is gone: unplugged, or its driver gave up. `ServoLink.reconnect()` when it is back."""


class BoardResetError(LinkError):
    """The board has booted since the last hello: servos are detached. `ServoLink.reconnect()`, then `arm()` again."""


class RefusedError(LinkError):
    """The board refused a request; `status` says why."""

    def __init__(self, port: str, kind: Request, status: Status) -> None:
        super().__init__(f"serial port {port}: the board refused {kind.name}: {status.name}")
        self.status = status


class Exchange:
    """An open port and the sequence number of its session; not safe for several threads."""

    def __init__(self, port: str) -> None:
        """Open `port`; raises InputError if it cannot be opened."""
        self.port = port
        self.bytes_heard = 0
        self.repeats = 0  # requests that were sent again
        self._serial: serial.Serial = open_port(port, POLL_S)
        self._reader = framing.FrameReader()
        self._sequence = 0

    def ask(self, kind: Request, body: bytes = b"", attempts: int = ATTEMPTS) -> bytes:
        """Send a request, again up to `attempts` times if no answer comes; return the answer's body behind its status.

        Raises LinkError if none comes, LinkLostError if the port is gone, BoardResetError or RefusedError if the board
        says so.
        """
        self._sequence = (self._sequence + 1) % 256
        frame = framing.encode(messages.request(kind, self._sequence, body))
        for attempt in range(attempts):
            self.repeats += attempt > 0
            self._write(frame)
            answer = self._await(kind)
            if answer is None:
                continue
            status, rest = answer
            if status is Status.NO_HELLO:
                raise BoardResetError(f"serial port {self.port}: the board was reset; its servos are detached")
            if status is not Status.OK:
                raise RefusedError(self.port, kind, status)
            return rest
        raise LinkError(f"serial port {self.port}: no answer to {kind.name}, sent {attempts} times")

    def close(self) -> None:
        """Close the port; its lock is released."""
        self._serial.close()

    def _await(self, kind: Request) -> tuple[Status, bytes] | None:
        deadline = time.monotonic() + ANSWER_TIMEOUT_S
        while time.monotonic() < deadline:
            for payload in self._reader.feed(self._read()):
                try:
                    answered, sequence, status, body = messages.split_answer(payload)
                except messages.MessageError:
                    continue  # noise that happens to be a frame
                if answered == kind and sequence == self._sequence:
                    return status, body
        return None

    def _read(self) -> bytes:
        try:
            data: bytes = self._serial.read(1)
            data += self._serial.read(self._serial.in_waiting)
        except (serial.SerialException, OSError) as error:
            raise LinkLostError(f"serial port {self.port}: lost ({error})") from None
        self.bytes_heard += len(data)
        return data

    def _write(self, frame: bytes) -> None:
        try:
            self._serial.write(frame)
        except (serial.SerialException, OSError) as error:
            raise LinkLostError(f"serial port {self.port}: lost ({error})") from None
