"""A small whole recording to write, spoil and read back."""

from __future__ import annotations

import numpy as np
import pytest

from armtwin.models.arm import nominal_arm
from armtwin.models.camera import Camera
from armtwin.models.lenses import PlumbBob
from armtwin.models.recordings.recording import Recording


def small_camera() -> Camera:
    return Camera(
        1280,
        720,
        np.array([[1438.6338, 0.0, 654.1560], [0.0, 1439.1291, 369.6557], [0.0, 0.0, 1.0]]),
        PlumbBob(np.array([0.1630, 0.0428, 0.0064, 0.0016, -2.1819])),
        np.diag([-1.0, -1.0, 1.0]),
        np.array([118.6608, 41.3400, 565.4370]),
    )


@pytest.fixture
def recording() -> Recording:
    """Six poses of two trajectories, two markers, one of them once unseen."""
    rng = np.random.default_rng(0)
    pixels = {name: rng.uniform(100, 600, (6, 2)) for name in "af"}
    pixels["f"][2] = np.nan
    return Recording(
        arm=nominal_arm(),
        camera=small_camera(),
        arm_plane_z_mm=-80.87,
        pixel_noise_px=0.06,
        held_out=("line",),
        sample=np.arange(6),
        time_s=np.array([0.0, 1.0, np.nan, 2.5, 2.5, 4.0]),
        trajectory=np.array(["circle", "circle", "circle", "circle", "line", "line"]),
        q_cmd=rng.uniform(-1, 1, (6, 3)),
        markers_px=pixels,
    )
