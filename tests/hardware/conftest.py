from __future__ import annotations

from collections.abc import Iterator

import pytest

from armtwin.hardware.emulator import FirmwareEmulator, missing_packages
from armtwin.hardware.link.servo_link import ServoLink
from tests.support.bench import bench_table, scene, setup, write_bench

__all__ = ["bench_table", "scene", "setup", "write_bench"]

SPEED = 4.0  # times real time, so that waiting for the firmware's two seconds of silence takes half a second


def pytest_runtest_setup(item: pytest.Item) -> None:
    if item.get_closest_marker("avr") and (reason := missing_packages()):
        pytest.skip(reason)


@pytest.fixture
def board() -> Iterator[FirmwareEmulator]:
    with FirmwareEmulator(speed=SPEED) as emulator:
        yield emulator


@pytest.fixture
def link(board: FirmwareEmulator) -> Iterator[ServoLink]:
    with ServoLink(board.port) as connected:
        yield connected
