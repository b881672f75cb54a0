"""The command `python -m armtwin.hardware.emulator.fuzz` with fewer frames."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from armtwin.hardware.emulator.fuzz import fuzz_armed, fuzz_limp, fuzz_link
from armtwin.hardware.emulator.noise import bad_piece
from armtwin.hardware.link.framing import FrameReader, encode


@pytest.mark.avr
@pytest.mark.parametrize("fuzz", [fuzz_limp, fuzz_armed, fuzz_link])
def test_bad_frames_do_no_harm_and_every_good_one_is_answered(fuzz: Callable[[int, int], str]) -> None:
    assert "bad frames" in fuzz(300, 7)


def test_bad_pieces_complete_no_frame_and_cost_none_after_them() -> None:
    rng = np.random.default_rng(0)
    receiver = FrameReader()
    for _ in range(2000):
        piece = bad_piece(rng, receiver)
        assert receiver.feed(piece) == []
        assert receiver.feed(encode(b"good")) == [b"good"]
