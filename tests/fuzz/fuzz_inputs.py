"""Spoil files of every kind and read them: one line, in seconds, within memory, or it is a defect.

python -m tests.fuzz.fuzz_inputs --mutations 5000          # half with a fixed seed, half with a fresh one
python -m tests.fuzz.fuzz_inputs --seed 123                # again what a failure named
"""

from __future__ import annotations

import argparse
import resource
import secrets
import signal
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import FrameType

import numpy as np

from armtwin.models.errors import ArmtwinError
from tests.fuzz.kinds import Kind, make_kinds
from tests.fuzz.mutations import mutated

SECONDS = 20
# What may be added to the program's memory at its start: nothing that a small file says takes a gigabyte.
MEMORY_BYTES = 1 << 30
FIXED_SEED = 20260726


@dataclass(frozen=True)
class Failure:
    """A mutation that was not answered as it should be."""

    kind: str
    seed: int
    number: int
    what: str


def fuzz(folder: Path, seed: int, mutations: int) -> list[Failure]:
    """Spoil the files of every kind by turns, `mutations` in all; return what was answered badly."""
    kinds = make_kinds(folder)
    good = {kind.name: kind.path.read_bytes() for kind in kinds}
    failures = []
    for number in range(mutations):
        kind = kinds[number % len(kinds)]
        kind.path.write_bytes(mutated(good[kind.name], np.random.default_rng([seed, number])))
        what = _answer(kind)
        if what is not None:
            failures.append(Failure(kind.name, seed, number, what))
        kind.path.write_bytes(good[kind.name])
    return failures


def _answer(kind: Kind) -> str | None:
    """Return what is wrong with how a file was answered, or None."""
    try:
        with _limits():
            kind.read()
    except ArmtwinError as error:
        text = str(error)
        if "\n" in text or len(text) > 2000:
            return f"a message of {len(text)} characters and {text.count(chr(10)) + 1} lines"
    except OSError as error:
        return None if error.filename else f"OSError without a file: {error}"
    except BaseException as error:
        if isinstance(error, KeyboardInterrupt):
            raise
        return f"{type(error).__name__}: {str(error)[:200]}"
    return None


@contextmanager
def _limits() -> Iterator[None]:
    """Raise TimeoutError or MemoryError where the block takes too long or too much."""

    def late(_: int, __: FrameType | None) -> None:
        raise TimeoutError(f"more than {SECONDS} s")

    size = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    before, hard = resource.getrlimit(resource.RLIMIT_AS)
    old = signal.signal(signal.SIGALRM, late)
    resource.setrlimit(resource.RLIMIT_AS, (size + MEMORY_BYTES, hard))
    signal.alarm(SECONDS)
    try:
        yield
    finally:
        signal.alarm(0)
        resource.setrlimit(resource.RLIMIT_AS, (before, hard))
        signal.signal(signal.SIGALRM, old)


def main() -> None:
    """Run from the command line; exit code 1 where something was answered badly."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--mutations", type=int, default=5000)
    parser.add_argument("--seed", type=int, help="only this one")
    said = parser.parse_args()
    seeds = [FIXED_SEED, secrets.randbelow(2**31)] if said.seed is None else [said.seed]
    failures = []
    for seed in seeds:
        started = time.monotonic()
        with tempfile.TemporaryDirectory() as folder:
            found = fuzz(Path(folder), seed, said.mutations // len(seeds))
        each = said.mutations // len(seeds)
        print(f"seed {seed}: {each} mutations, {len(found)} answered badly, {time.monotonic() - started:.0f} s")
        failures += found
    for one in failures:
        print(f"{one.kind}, mutation {one.number} of seed {one.seed}: {one.what}")
    sys.exit(1 if failures else 0)


if __name__ == "__main__":
    main()
