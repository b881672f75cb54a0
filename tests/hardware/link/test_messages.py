from __future__ import annotations

import contextlib
from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from armtwin.hardware.link import messages
from armtwin.hardware.link.messages import DetachReason, MessageError, Status


def test_hello_is_read_in_physical_units() -> None:
    hello = messages.parse_hello(bytes.fromhex("02 02 00 06 e803 8813 a00f d007"))
    assert hello == messages.Hello(2, (2, 0), 6, 500.0, 2500.0, 2000.0, 2.0)


def test_state_is_read_in_physical_units() -> None:
    state = messages.parse_state(bytes.fromhex("02 03 10270000 0500 b80b b90b 8913"))
    assert state == messages.BoardState(False, True, DetachReason.SILENCE, 10.0, 5, (1500.0, 1500.5, 2500.5))


@pytest.mark.parametrize("n", [0, 1, 6])
def test_a_state_has_a_width_for_each_servo_that_was_armed(n: int) -> None:
    state = messages.parse_state(bytes.fromhex("01 00 10270000 0500") + messages.widths_body([3000] * n))
    assert state.pulses_us == (1500.0,) * n


@pytest.mark.parametrize("widths", ["b8", "b80b" * 7])
def test_half_a_width_and_a_seventh_servo_are_refused(widths: str) -> None:
    with pytest.raises(MessageError, match="bytes of pulse widths"):
        messages.parse_state(bytes.fromhex("01 00 10270000 0500" + widths))


def test_an_answer_is_split_into_request_sequence_status_and_rest() -> None:
    assert messages.split_answer(bytes.fromhex("83 07 00 f401")) == (3, 7, Status.OK, b"\xf4\x01")


@pytest.mark.parametrize("payload", ["03 07 00", "83 07", "83 07 63"], ids=["request", "short", "unknown status"])
def test_what_is_no_answer_is_refused(payload: str) -> None:
    with pytest.raises(MessageError):
        messages.split_answer(bytes.fromhex(payload))


@pytest.mark.parametrize(
    "parse", [messages.split_answer, messages.parse_hello, messages.parse_state, messages.parse_duration]
)
@given(content=st.binary(max_size=40))
def test_no_content_breaks_a_parser(parse: Callable[[bytes], object], content: bytes) -> None:
    with contextlib.suppress(MessageError):
        parse(content)
