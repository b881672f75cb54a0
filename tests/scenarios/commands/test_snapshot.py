"""Photographs of a board through a real stream on loopback, before anything is calibrated."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
import tomli_w

from armtwin.calib.camera.board import Board
from armtwin.hardware.emulator.mjpeg import MjpegServer, to_jpeg
from armtwin.models.errors import InputError
from armtwin.scenarios.commands.snapshot import snapshot_command, take_snapshots
from tests.support.bench import bench_table

__all__ = ["bench_table"]

SIZE = (640, 360)
BOARD = Board(9, 6, 20.0)


class BoardStream:
    """Films a chessboard with a sensor's noise, or the dark."""

    def __init__(self) -> None:
        self.dark = False
        self._rng = np.random.default_rng(0)
        squares = np.kron(np.indices((7, 10)).sum(0) % 2, np.ones((40, 40)))
        self._light = np.full((SIZE[1], SIZE[0]), 200.0)
        self._light[40:320, 120:520] = 40.0 + 160.0 * squares
        self.server = MjpegServer()
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def _run(self) -> None:
        while not self._stop.wait(0.02):
            light = np.full_like(self._light, 3.0) if self.dark else self._light
            noisy = np.clip(cv2.GaussianBlur(light, (0, 0), 0.7) + self._rng.normal(0, 2, light.shape), 0, 255)
            self.server.publish(to_jpeg(np.repeat(noisy.astype(np.uint8)[..., None], 3, axis=2)))

    def close(self) -> None:
        self._stop.set()
        self._thread.join()
        self.server.close()


@pytest.fixture
def stream() -> Iterator[BoardStream]:
    running = BoardStream()
    yield running
    running.close()


@pytest.fixture
def bench(bench_table: dict[str, Any], stream: BoardStream, tmp_path: Path) -> Path:
    """Return a bench file whose camera was never calibrated: no camera file is beside it."""
    bench_table["camera"]["source"] = stream.server.url
    path = tmp_path / "bench.toml"
    path.write_text(tomli_w.dumps(bench_table))
    return path


def test_photographs_are_numbered_and_show_the_board_and_more_are_added(
    bench: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    take_snapshots(bench, tmp_path / "views", 2, BOARD, SIZE, lambda _: None)
    take_snapshots(bench, tmp_path / "views", 1, BOARD, SIZE, lambda _: None)

    names = sorted(path.name for path in (tmp_path / "views").iterdir())
    assert names == ["view-01.png", "view-02.png", "view-03.png"]
    image = cv2.imread(str(tmp_path / "views" / "view-03.png"), cv2.IMREAD_GRAYSCALE)
    assert BOARD.find("view", np.asarray(image, np.uint8)) is not None
    assert capsys.readouterr().out.count("the board is seen") == 3


def test_a_dark_picture_is_not_kept_and_another_is_taken(
    bench: Path, stream: BoardStream, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    stream.dark = True
    asked = 0

    def wait(_: int) -> None:
        nonlocal asked
        asked += 1
        if asked == 2:
            stream.dark = False
            threading.Event().wait(0.3)

    take_snapshots(bench, tmp_path / "views", 1, BOARD, SIZE, wait)
    assert "not kept: " in capsys.readouterr().out
    assert len(list((tmp_path / "views").iterdir())) == 1


def test_without_a_terminal_it_has_to_be_said_when(bench: Path, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="--every: nobody is at a terminal"):
        snapshot_command(bench, tmp_path / "views")
    with pytest.raises(InputError, match="--size: 'big' is no width x height"):
        snapshot_command(bench, tmp_path / "views", size="big", every=1.0)
