"""Bad frames, and a serial line that is full of them: what a loose plug and a long cable beside motors do."""

from __future__ import annotations

import contextlib
import copy
import os
import pty
import select
import threading
import tty

import numpy as np

from armtwin.hardware.link.framing import MAX_BLOCK, MIN_PAYLOAD, FrameReader, encode
from armtwin.hardware.link.ports import open_port

CHUNK = 4096
POLL_S = 0.05


def bad_piece(rng: np.random.Generator, reader: FrameReader) -> bytes:
    """Random, truncated, corrupted or oversized bytes that complete no good frame at a receiver in `reader`'s state.

    A CRC of 16 bits lets one random block in 65,536 pass; such a piece is a good frame, and is drawn again.
    """
    while True:
        piece = _piece(rng)
        if not copy.deepcopy(reader).feed(piece):
            return piece


def good_payload(rng: np.random.Generator) -> bytes:
    """Payload of random content that a frame may have."""
    return rng.bytes(int(rng.integers(MIN_PAYLOAD, MAX_BLOCK - 2)))


def _piece(rng: np.random.Generator) -> bytes:
    frame = bytearray(encode(good_payload(rng)))
    match rng.integers(5):
        case 0:  # random bytes, zeros among them
            return rng.bytes(int(rng.integers(1, 40)))
        case 1:  # truncated, the end lost
            return bytes(frame[: int(rng.integers(1, len(frame) - 1))])
        case 2:  # truncated, the beginning lost
            return bytes(frame[int(rng.integers(2, len(frame))) :])
        case 3:  # one to three bytes changed
            for at in rng.integers(1, len(frame), int(rng.integers(1, 4))):
                frame[at] ^= int(rng.integers(1, 256))
            return bytes(frame)
        case _:  # far too long
            return bytes(rng.integers(1, 256, int(rng.integers(MAX_BLOCK, 6 * MAX_BLOCK)), dtype=np.uint8))


class NoisyLine:
    """Stands between a host and the serial port `port`, and puts bad frames before every good one, both ways.

    Of the good frames a share `lost` is corrupted on the way and a share `repeated` arrives twice. The host opens
    `self.port`. Use as a context manager.
    """

    def __init__(self, port: str, *, seed: int, bad_frames: int, lost: float = 0.0, repeated: float = 0.0) -> None:
        self._board = open_port(port, 0.0)
        self._master, self._slave = pty.openpty()
        tty.setraw(self._slave)
        self.port = os.ttyname(self._slave)
        self.bad_to_board = self.bad_to_host = 0
        self._rng = np.random.default_rng(seed)
        self._bad_frames, self._lost, self._repeated = bad_frames, lost, repeated
        self._from_host, self._from_board = FrameReader(), FrameReader()
        self._at_board, self._at_host = FrameReader(), FrameReader()  # what the receivers have seen
        self._ending = threading.Event()
        self._thread = threading.Thread(target=self._relay, name="noisy-line", daemon=True)

    def __enter__(self) -> NoisyLine:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._ending.set()
        self._thread.join()
        self._board.close()
        os.close(self._master)
        os.close(self._slave)

    def _relay(self) -> None:
        board = self._board.fileno()
        while not self._ending.is_set():
            ready, _, _ = select.select([self._master, board], [], [], POLL_S)
            if self._master in ready:
                for payload in self._from_host.feed(os.read(self._master, CHUNK)):
                    self._board.write(self._spoiled(payload, self._at_board))
                    self.bad_to_board += self._bad_frames
            if board in ready:
                for payload in self._from_board.feed(os.read(board, CHUNK)):
                    with contextlib.suppress(OSError):  # a host that has gone misses nothing
                        os.write(self._master, self._spoiled(payload, self._at_host))
                    self.bad_to_host += self._bad_frames

    def _spoiled(self, payload: bytes, receiver: FrameReader) -> bytes:
        out = bytearray()
        for _ in range(self._bad_frames):
            piece = bad_piece(self._rng, receiver)
            receiver.feed(piece)
            out += piece
        frame = bytearray(encode(payload))
        if self._rng.random() < self._lost:
            frame[int(self._rng.integers(1, len(frame) - 1))] ^= 0x55
        elif self._rng.random() < self._repeated:
            frame *= 2
        receiver.feed(bytes(frame))
        return bytes(out + frame)
