"""Frames of the serial protocol: COBS blocks between zero bytes, each closed by a CRC-16.

On the wire a frame is `00 | COBS(payload | crc) | 00`. COBS (Cheshire and Baker, "Consistent Overhead Byte Stuffing",
IEEE/ACM Trans. Networking 7(2), 1999) leaves no zero byte inside a block, so a zero is always a boundary and a reader
that lost its place finds it again at the next one. The zero in front ends whatever noise came before, so that noise
costs no good frame. `protocol.md` beside this file is the specification, with examples byte for byte.
"""

from __future__ import annotations

import binascii

from cobs import cobs

DELIMITER = b"\x00"
CRC_INITIAL = 0xFFFF  # CRC-16/CCITT-FALSE: polynomial 0x1021, not reflected; check value 0x29B1 over "123456789"
CRC_BYTES = 2
MIN_PAYLOAD = 2  # bytes: type and sequence number
MAX_PAYLOAD = 32  # bytes; the longest message has 14, the rest is room for later versions
MAX_BLOCK = MAX_PAYLOAD + CRC_BYTES + 1  # COBS adds one byte to anything shorter than 254


class FrameError(ValueError):
    """A block between two zero bytes is not a good frame."""


def crc16(data: bytes) -> int:
    """CRC-16/CCITT-FALSE of `data`, 0 to 65535."""
    return binascii.crc_hqx(data, CRC_INITIAL)


def encode(payload: bytes) -> bytes:
    """Frame of a payload, both delimiters included; raises ValueError unless it has 2 to 32 bytes."""
    if not MIN_PAYLOAD <= len(payload) <= MAX_PAYLOAD:
        raise ValueError(f"a payload has {MIN_PAYLOAD} to {MAX_PAYLOAD} bytes, not {len(payload)}")
    block: bytes = cobs.encode(payload + crc16(payload).to_bytes(CRC_BYTES, "little"))
    return DELIMITER + block + DELIMITER


def decode(block: bytes) -> bytes:
    """Payload of a block (what stands between two delimiters); raises FrameError if it is not a good one."""
    if len(block) > MAX_BLOCK:
        raise FrameError(f"{len(block)} bytes, at most {MAX_BLOCK} are allowed")
    try:
        data: bytes = cobs.decode(block)
    except cobs.DecodeError as error:
        raise FrameError(f"not COBS: {error}") from None
    payload, crc = data[:-CRC_BYTES], data[-CRC_BYTES:]
    if len(payload) < MIN_PAYLOAD:
        raise FrameError(f"{len(data)} bytes, at least {MIN_PAYLOAD + CRC_BYTES} are needed")
    if crc16(payload) != int.from_bytes(crc, "little"):
        raise FrameError("wrong CRC")
    return payload


class FrameReader:
    """Finds the good frames in a stream that arrives in pieces, and counts the blocks that were none.

    Holds at most `MAX_BLOCK + 1` bytes however long the noise: a block that grows longer is dropped up to its end.
    """

    def __init__(self) -> None:
        self.bad_frames = 0
        self._block = bytearray()

    def feed(self, data: bytes) -> list[bytes]:
        """Payloads of the frames that `data` completes, in order."""
        payloads = []
        for byte in data:
            if byte:
                if len(self._block) <= MAX_BLOCK:
                    self._block.append(byte)
                continue
            if self._block:
                try:
                    payloads.append(decode(bytes(self._block)))
                except FrameError:
                    self.bad_frames += 1
                self._block.clear()
        return payloads
