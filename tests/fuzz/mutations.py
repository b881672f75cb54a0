"""How a file is spoilt: bytes, spans, numbers, words, structure."""

from __future__ import annotations

import re
from collections.abc import Callable

from numpy.random import Generator

_WORDS = [
    *(b"nan", b"-inf", b"1e308", b"-1e308", b"1e-320", b"0", b"-1", b"99999999999999999999", b"1" * 5000),
    *(
        b"",
        b"null",
        b"true",
        b'""',
        b"[]",
        b"{}",
        b"[" * 5000,
        b"../../etc/passwd",
        b"\xff\xfe",
        b"\x00",
        b"\xe2\x88\x92",
    ),
    *(b"&a [*a,*a]", b"!!python/object:os.system x", b"=cmd()", b"\x1b[2J", b"\n\n", b";", b"\t", b"'", b'"', b"#"),
]
_NUMBER = re.compile(rb"-?\d+\.?\d*(?:[eE][-+]?\d+)?")
_WORD = re.compile(rb"[A-Za-z_]{2,}")

Mutation = Callable[[bytes, Generator], bytes]


def mutated(data: bytes, rng: Generator) -> bytes:
    """Return the data with one to three things wrong with it."""
    for _ in range(int(rng.integers(1, 4))):
        data = _MUTATIONS[int(rng.integers(len(_MUTATIONS)))](data, rng)
    return data


def _span(data: bytes, rng: Generator) -> tuple[int, int]:
    start = int(rng.integers(0, len(data) + 1))
    return start, min(len(data), start + int(rng.integers(1, 200)))


def _flip(data: bytes, rng: Generator) -> bytes:
    out = bytearray(data)
    for _ in range(int(rng.integers(1, 6))):
        if out:
            out[int(rng.integers(len(out)))] ^= 1 << int(rng.integers(8))
    return bytes(out)


def _cut(data: bytes, rng: Generator) -> bytes:
    return data[: int(rng.integers(0, len(data) + 1))]


def _drop(data: bytes, rng: Generator) -> bytes:
    start, end = _span(data, rng)
    return data[:start] + data[end:]


def _repeat(data: bytes, rng: Generator) -> bytes:
    start, end = _span(data, rng)
    return data[:end] + data[start:end] * int(rng.integers(1, 50)) + data[end:]


def _insert(data: bytes, rng: Generator) -> bytes:
    at = int(rng.integers(0, len(data) + 1))
    return data[:at] + _WORDS[int(rng.integers(len(_WORDS)))] + data[at:]


def _replace(pattern: re.Pattern[bytes], data: bytes, rng: Generator) -> bytes:
    found = list(pattern.finditer(data))
    if not found:
        return data
    one = found[int(rng.integers(len(found)))]
    return data[: one.start()] + _WORDS[int(rng.integers(len(_WORDS)))] + data[one.end() :]


def _number(data: bytes, rng: Generator) -> bytes:
    return _replace(_NUMBER, data, rng)


def _scale(data: bytes, rng: Generator) -> bytes:
    """Shift a number by orders of magnitude: it stays plausible to a parser."""
    found = list(_NUMBER.finditer(data))
    if not found:
        return data
    one = found[int(rng.integers(len(found)))]
    return data[: one.end()] + b"0" * int(rng.integers(1, 12)) + data[one.end() :]


def _word(data: bytes, rng: Generator) -> bytes:
    return _replace(_WORD, data, rng)


def _lines(data: bytes, rng: Generator) -> bytes:
    lines = data.split(b"\n")
    first, second = (int(rng.integers(len(lines))) for _ in range(2))
    lines[first], lines[second] = lines[second], lines[first]
    return b"\n".join(lines)


# Numbers twice: most of what a file says is one.
_MUTATIONS: tuple[Mutation, ...] = (
    *(_flip, _cut, _drop, _repeat, _insert),
    *(_number, _number, _scale, _scale, _word, _lines),
)
