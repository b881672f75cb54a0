"""Messages inside the frames: what the host asks of the board and what the board answers (`protocol.md`).

A payload is `type, sequence, body`; all numbers are little-endian, pulse widths count ticks of 0.5 us. An answer has
the request's type with bit 7 set, its sequence number, and a status in front of its body.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from enum import IntEnum

PROTOCOL_VERSION = 2
FIRMWARE_MAJOR = 2  # of the firmware beside this file; another may act otherwise on the same messages
MOST_SERVOS = 6  # of any board; how many one drives, it says itself
MAX_DURATION_S = 60.0  # of a move
TICKS_PER_US = 2  # widths are commanded in steps of 0.5 us
ANSWER = 0x80  # bit of the type that tells an answer from a request

_HELLO = struct.Struct("<BBBBHHHH")
_STATE = struct.Struct("<BBIH")
_DURATION = struct.Struct("<H")
_WIDTH_BYTES = 2


class Request(IntEnum):
    """Types of requests."""

    HELLO = 0x01
    ARM = 0x02
    MOVE = 0x03
    STATE = 0x04
    DETACH = 0x05
    STOP = 0x06


class Status(IntEnum):
    """First byte of every answer's body."""

    OK = 0
    UNKNOWN_TYPE = 1
    BAD_LENGTH = 2
    NO_HELLO = 3
    NOT_ARMED = 4
    ALREADY_ARMED = 5
    BAD_WIDTH = 6
    BAD_DURATION = 7


class DetachReason(IntEnum):
    """Why the board sends no pulses; NONE while it is armed."""

    NONE = 0
    BOOT = 1
    COMMAND = 2
    SILENCE = 3
    HELLO = 4


@dataclass(frozen=True)
class Hello:
    """What the board says of itself; widths in us, `slew_us_per_s` the fastest change of a pulse width.

    `n_servos` is how many it can drive.
    """

    protocol_version: int
    firmware_version: tuple[int, int]
    n_servos: int
    min_pulse_us: float
    max_pulse_us: float
    slew_us_per_s: float
    silence_timeout_s: float


@dataclass(frozen=True)
class BoardState:
    """State of the board; `pulses_us` are the widths it sends now, or sent last if it is not armed; none before."""

    armed: bool
    moving: bool
    detach_reason: DetachReason
    uptime_s: float
    bad_frames: int
    pulses_us: tuple[float, ...]


class MessageError(ValueError):
    """A good frame whose content is no message of this protocol."""


def request(kind: Request, sequence: int, body: bytes = b"") -> bytes:
    """Payload of a request."""
    return bytes((kind, sequence)) + body


def widths_body(ticks: list[int]) -> bytes:
    """Body of ARM: one width a servo, in ticks."""
    return struct.pack(f"<{len(ticks)}H", *ticks)


def move_body(duration_ms: int, ticks: list[int]) -> bytes:
    """Body of MOVE: duration in ms, then one width a servo, in ticks."""
    return _DURATION.pack(duration_ms) + widths_body(ticks)


def split_answer(payload: bytes) -> tuple[int, int, Status, bytes]:
    """Request type, sequence number, status and rest of an answer; raises MessageError for anything else."""
    if len(payload) < 3 or not payload[0] & ANSWER:
        raise MessageError("not an answer")
    try:
        status = Status(payload[2])
    except ValueError:
        raise MessageError(f"unknown status {payload[2]}") from None
    return payload[0] & ~ANSWER, payload[1], status, payload[3:]


def parse_hello(body: bytes) -> Hello:
    """HELLO's answer behind its status; raises MessageError if its length is wrong.

    The first byte is the protocol version in every version of the protocol, so `body[0]` may be read before.
    """
    protocol, major, minor, n_servos, shortest, longest, slew_per_s, silence_ms = _unpack(_HELLO, body)
    return Hello(
        protocol_version=protocol,
        firmware_version=(major, minor),
        n_servos=n_servos,
        min_pulse_us=shortest / TICKS_PER_US,
        max_pulse_us=longest / TICKS_PER_US,
        slew_us_per_s=slew_per_s / TICKS_PER_US,
        silence_timeout_s=silence_ms / 1000,
    )


def parse_state(body: bytes) -> BoardState:
    """STATE's answer behind its status; raises MessageError if its length or reason is wrong."""
    flags, reason, uptime_ms, bad_frames = _unpack(_STATE, body[: _STATE.size])
    widths = body[_STATE.size :]
    if len(widths) % _WIDTH_BYTES or len(widths) > MOST_SERVOS * _WIDTH_BYTES:
        raise MessageError(f"{len(widths)} bytes of pulse widths")
    ticks = struct.unpack(f"<{len(widths) // _WIDTH_BYTES}H", widths)
    try:
        detach_reason = DetachReason(reason)
    except ValueError:
        raise MessageError(f"unknown reason {reason}") from None
    pulses_us = tuple(tick / TICKS_PER_US for tick in ticks)
    return BoardState(bool(flags & 1), bool(flags & 2), detach_reason, uptime_ms / 1000, bad_frames, pulses_us)


def parse_duration(body: bytes) -> float:
    """MOVE's answer behind its status: the seconds that the board takes; raises MessageError if its length is wrong."""
    return float(_unpack(_DURATION, body)[0]) / 1000


def _unpack(layout: struct.Struct, body: bytes) -> tuple[int, ...]:
    if len(body) != layout.size:
        raise MessageError(f"{len(body)} bytes where {layout.size} are wanted")
    return layout.unpack(body)
