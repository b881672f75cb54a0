"""A bench in a file, and pictures of a scene with an arm-like bar; fixtures, imported by the conftest files."""

from __future__ import annotations

import copy
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
import tomli_w

from armtwin.hardware.bench.bench_file import BenchSetup, read_bench
from armtwin.models.camera_files import nominal_camera, write_camera

BENCH: dict[str, Any] = {
    "schema": "armtwin.bench/1",
    "serial": {"port": "/dev/ttyACM0"},
    "camera": {"source": "/dev/video0", "calibration": "camera.yaml", "arm_plane_z_mm": -80.87},
    "joints": [
        {"servo": 1, "zero_us": 1500.0, "us_per_rad": 636.62, "direction": 1, "min_rad": -1.2, "max_rad": 1.2},
        {"servo": 2, "zero_us": 1500.0, "us_per_rad": 636.62, "direction": -1, "min_rad": -1.2, "max_rad": 1.2},
        {"servo": 3, "zero_us": 1450.0, "us_per_rad": 600.0, "direction": 1, "min_rad": -1.4, "max_rad": 1.2},
    ],
}


@pytest.fixture
def bench_table() -> dict[str, Any]:
    """Return the content of a good bench file, to be spoilt at will."""
    return copy.deepcopy(BENCH)


@pytest.fixture
def write_bench(tmp_path: Path) -> Callable[[dict[str, Any]], Path]:
    """Return what writes a bench file with its camera file beside it."""

    def write(table: dict[str, Any]) -> Path:
        write_camera(tmp_path / "camera.yaml", nominal_camera())
        path = tmp_path / "bench.toml"
        path.write_bytes(tomli_w.dumps(table).encode())
        return path

    return write


@pytest.fixture
def setup(bench_table: dict[str, Any], write_bench: Callable[[dict[str, Any]], Path]) -> BenchSetup:
    """Return the good bench, read."""
    return read_bench(write_bench(bench_table))


class Scene:
    """A chequered ground under a bar that is turned about the picture's centre, seen with a sensor's noise."""

    def __init__(self, width: int = 640, height: int = 360, noise: float = 2.0) -> None:
        tile = np.kron(np.indices((8, 12)).sum(0) % 2, np.ones((height // 8, width // 12)))
        self._ground = np.full((height, width, 3), 70, np.uint8)
        self._ground[: tile.shape[0], : tile.shape[1]] += (110 * tile[..., None]).astype(np.uint8)
        self._noise = noise
        self._random = np.random.default_rng(0)
        self.angle_rad = 0.0

    def picture(self) -> np.ndarray:
        """Draw the bar where it stands now; the noise is new each time."""
        height, width = self._ground.shape[:2]
        centre = np.array([width / 2, height / 2])
        tip = centre + 0.4 * height * np.array([np.cos(self.angle_rad), np.sin(self.angle_rad)])
        image = self._ground.copy()
        bits = 4  # of a pixel's fraction
        ends = [tuple(round(v * (1 << bits)) for v in point) for point in (centre, tip)]
        cv2.line(image, ends[0], ends[1], (30, 30, 200), 14, cv2.LINE_AA, bits)
        noisy = image + self._random.normal(0.0, self._noise, image.shape)
        return np.clip(np.round(noisy), 0, 255).astype(np.uint8)


@pytest.fixture
def scene() -> Scene:
    """Return a scene at rest."""
    return Scene()
