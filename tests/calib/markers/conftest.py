"""The paper's webcam, and the same camera before a board tilted by 25 degrees more."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from armtwin.models.camera import Camera
from armtwin.models.camera_files import nominal_camera


@pytest.fixture(scope="session")
def webcam() -> Camera:
    return nominal_camera()


@pytest.fixture(scope="session")
def tilted(webcam: Camera) -> Camera:
    return replace(
        webcam, R_board_camera=webcam.R_board_camera @ Rotation.from_euler("x", 25, degrees=True).as_matrix()
    )


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(7)
