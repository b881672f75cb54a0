from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from armtwin.hardware.link.framing import MAX_BLOCK, FrameError, FrameReader, crc16, decode, encode

payloads = st.binary(min_size=2, max_size=32)


def test_crc_has_the_check_value_of_the_catalogue() -> None:
    assert crc16(b"123456789") == 0x29B1


@given(payloads)
def test_a_frame_has_zeros_only_at_its_ends(payload: bytes) -> None:
    frame = encode(payload)
    assert frame[0] == frame[-1] == 0
    assert 0 not in frame[1:-1]


@given(payloads)
def test_a_payload_comes_back_from_its_frame(payload: bytes) -> None:
    assert decode(encode(payload)[1:-1]) == payload


@given(st.lists(payloads, max_size=5), st.data())
def test_frames_are_found_however_the_stream_is_cut(sent: list[bytes], data: st.DataObject) -> None:
    stream = b"".join(map(encode, sent))
    cut = data.draw(st.integers(0, len(stream)))
    reader = FrameReader()
    assert reader.feed(stream[:cut]) + reader.feed(stream[cut:]) == sent


@given(st.binary(max_size=200), payloads)
def test_noise_costs_no_frame_after_it(noise: bytes, payload: bytes) -> None:
    assert FrameReader().feed(noise + encode(payload))[-1:] == [payload]


@pytest.mark.parametrize("bit", range(8))
def test_a_frame_with_one_wrong_bit_is_refused(bit: int) -> None:
    payload = bytes.fromhex("0302f401800cb80bf10a")
    for at in range(1, len(encode(payload)) - 1):
        frame = bytearray(encode(payload))
        frame[at] ^= 1 << bit
        assert payload not in FrameReader().feed(bytes(frame))
        assert not FrameReader().feed(bytes(frame))


def test_every_bad_block_is_counted_once_and_two_zeros_are_none() -> None:
    reader = FrameReader()
    reader.feed(b"\0\0\0noise\0\0more noise\0")
    assert reader.bad_frames == 2


def test_a_block_without_end_is_dropped_and_takes_no_room() -> None:
    reader = FrameReader()
    assert reader.feed(b"\xff" * 100_000) == []
    assert len(reader._block) <= MAX_BLOCK + 1
    assert reader.feed(encode(b"ok")) == [b"ok"]


@pytest.mark.parametrize("payload", [b"", b"1", b"x" * 33])
def test_payloads_of_a_wrong_length_are_not_sent(payload: bytes) -> None:
    with pytest.raises(ValueError, match="2 to 32 bytes"):
        encode(payload)


def test_a_block_too_short_for_a_message_is_refused() -> None:
    with pytest.raises(FrameError, match="at least 4"):
        decode(b"\x04abc")
