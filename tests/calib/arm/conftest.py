"""Simulated recordings of an arm whose truth is known: kinematics, projection and pixel noise."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from armtwin.models.arm import Arm, nominal_arm
from armtwin.models.camera import Camera, project
from armtwin.models.coordinate_frames import robot_to_board
from armtwin.models.kinematics import Deviation, complex_links, inverse, link_angles, marker_positions
from armtwin.models.lenses import PlumbBob
from armtwin.models.recordings.recording import Recording
from armtwin.models.trajectories import paper_trajectories

ARM_PLANE_Z_MM = -80.87
BASE_MM = np.array([-35.0, -20.0, ARM_PLANE_Z_MM])


def table_2_camera() -> Camera:
    """The paper's camera (Table 2), its printed rotation transposed and made orthonormal."""
    printed = np.array([[-0.9988, -0.0047, 0.0496], [0.0041, -0.9999, -0.0129], [0.0497, -0.0127, 0.9987]])
    U, _, Vt = np.linalg.svd(printed.T)
    return Camera(
        1280,
        720,
        np.array([[1438.6338, 0.0, 654.1560], [0.0, 1439.1291, 369.6557], [0.0, 0.0, 1.0]]),
        PlumbBob(np.array([0.1630, 0.0428, 0.0064, 0.0016, -2.1819])),
        U @ Vt,
        np.array([118.6608, 41.3400, 565.4370]),
    )


def table_4() -> Deviation:
    """Table 4, second calibration."""
    return Deviation(np.array([6.7015, 4.5704, -0.7074, 1.0208]), np.radians([1.1354, 1.0037, 4.7563]))


def paper_commands() -> tuple[np.ndarray, np.ndarray]:
    """Trajectory names and commands of the paper's two circles and line."""
    poses = paper_trajectories()
    names = np.concatenate([np.full(len(p), name) for name, p in poses.items()])
    return names, inverse(nominal_arm(), np.concatenate(list(poses.values())))


def markers_of(arm: Arm, q: np.ndarray, delta: Deviation) -> dict[str, np.ndarray]:
    """(N, 2) robot mm of every marker that the arm can show, E too."""
    points = marker_positions(arm, q, delta)
    out = {name: points[:, i] for i, name in enumerate(arm.marker_names)}
    if arm.has_tip_offset:
        corner = complex_links(arm, delta)[2].real * np.exp(1j * link_angles(arm, q, delta)[:, 2])
        out[arm.form.corner] = out["c"] + np.stack([corner.real, corner.imag], axis=-1)
    return out


def simulate(
    *,
    arm: Arm | None = None,
    delta: Deviation | None = None,
    q_cmd: np.ndarray | None = None,
    trajectory: np.ndarray | None = None,
    markers: str = "abcf",
    noise_px: float = 0.0,
    seed: int = 0,
    held_out: tuple[str, ...] = (),
) -> Recording:
    """Return what a perfect bench with independent pixel noise would have recorded."""
    arm = arm or nominal_arm()
    delta = delta or Deviation.none(arm)
    if q_cmd is None:
        trajectory, q_cmd = paper_commands()
    if trajectory is None:
        trajectory = np.full(len(q_cmd), "poses")
    rng = np.random.default_rng(seed)
    camera = table_2_camera()
    seen = markers_of(arm, q_cmd, delta)
    pixels = {
        name: project(camera, robot_to_board(seen[name], BASE_MM)) + rng.normal(0.0, noise_px, (len(q_cmd), 2))
        for name in markers
    }
    return Recording(
        arm=arm,
        camera=camera,
        arm_plane_z_mm=ARM_PLANE_Z_MM,
        sample=np.arange(len(q_cmd)),
        time_s=np.full(len(q_cmd), np.nan),
        trajectory=trajectory,
        q_cmd=q_cmd,
        markers_px=pixels,
        held_out=held_out,
    )


@pytest.fixture(name="simulate")
def _simulate() -> Callable[..., Recording]:
    return simulate


@pytest.fixture
def table_4_deviation() -> Deviation:
    return table_4()
