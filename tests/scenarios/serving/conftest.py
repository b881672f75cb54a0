"""A served bench in a process of its own, as a person starts it."""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest

TOKEN = "a-token-for-tests"


@dataclass(frozen=True)
class Served:
    """The process, its address (without a slash at the end) and its folder."""

    process: subprocess.Popen[str]
    url: str
    out: Path


def start_server(out: Path, *options: str) -> Served:
    """Start `armtwin serve` and wait until it says where."""
    command = [sys.executable, "-m", "armtwin", "serve", "--port", "0", "--token", TOKEN, "--out", str(out), *options]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    assert process.stderr is not None
    for line in process.stderr:
        found = re.search(r"(http://127\.0\.0\.1:\d+)/\?token=", line)
        if found:
            return Served(process, found[1], out)
    raise AssertionError(f"the server ended with {process.wait()} and said nothing of its address")


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    server = start_server(tmp_path_factory.mktemp("served"))
    yield server
    server.process.terminate()
    server.process.wait(20)
