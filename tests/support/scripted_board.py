"""A serial port whose other end is no Arduino but a function: boards with another firmware, or none."""

from __future__ import annotations

import os
import pty
import select
import threading
import tty
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from armtwin.hardware.link.framing import FrameReader

HELLO = bytes.fromhex("02 02 00 06 e803 8813 a00f d007")  # behind its status: what a good board says of itself


@contextmanager
def scripted_board(answer: Callable[[bytes], bytes]) -> Iterator[str]:
    """A port whose other end sends `answer(payload)` to each frame that it is sent."""
    master, slave = pty.openpty()
    tty.setraw(slave)
    ending = threading.Event()

    def serve() -> None:
        reader = FrameReader()
        while not ending.is_set():
            if select.select([master], [], [], 0.02)[0]:
                for payload in reader.feed(os.read(master, 1000)):
                    os.write(master, answer(payload))

    thread = threading.Thread(target=serve)
    thread.start()
    try:
        yield os.ttyname(slave)
    finally:
        ending.set()
        thread.join()
        os.close(slave)
        os.close(master)
