"""Recordings made by plain formulas, for tests of the diagnosis that need no physics."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from armtwin.models.arm import nominal_arm
from armtwin.models.camera import Camera, project
from armtwin.models.camera_files import nominal_camera
from armtwin.models.coordinate_frames import robot_to_board
from armtwin.models.kinematics import Deviation, marker_positions
from armtwin.models.recordings.recording import Recording, make_samples

Array = NDArray[np.float64]
Bend = Callable[[Array], Array]

BASE_MM = np.array([45.0, -30.0, -80.87])
DEVIATION = Deviation(np.array([3.0, -2.0, 0.6, 0.3]), np.array([0.02, -0.03, 0.05]))


def waves(trajectories: int = 4, n: int = 30, seed: int = 0) -> dict[str, Array]:
    """Return named (n, 3) commands that swing all joints to and fro, rad."""
    rng = np.random.default_rng(seed)
    along = np.linspace(0.0, 1.0, n)
    return {
        f"wave_{k}": np.stack(
            [
                rng.uniform(0.2, 0.45) * np.sin(2 * np.pi * rng.uniform(0.8, 2.0) * along + rng.uniform(0, 6))
                for _ in range(3)
            ],
            axis=-1,
        )
        for k in range(trajectories)
    }


def recording(
    bend: Bend = lambda q: q,
    shift_px: Bend = lambda pixels: pixels,
    *,
    noise_px: float = 0.05,
    markers: str = "abcf",
    declare_noise: bool = True,
    gravity: float = 0.0,
    paths: dict[str, Array] | None = None,
    seed: int = 0,
    held_out: tuple[str, ...] = ("wave_3",),
    camera: Camera | None = None,
) -> Recording:
    """Return what a camera sees of an arm whose joints stand at `bend(q_cmd)`; `shift_px` acts on (N, 4, 2) pixels."""
    camera = camera or nominal_camera()
    arm = replace(nominal_arm(), gravity_m_s2=np.array([0.0, gravity]))
    paths = waves() if paths is None else paths
    q = np.concatenate(list(paths.values()))
    points = marker_positions(arm, bend(q), DEVIATION)
    pixels = project(camera, robot_to_board(points.reshape(-1, 2), BASE_MM)).reshape(points.shape)
    pixels = pixels + np.random.default_rng(seed).normal(0.0, noise_px, pixels.shape)
    pixels = shift_px(pixels)
    return Recording(
        arm=arm,
        sample=make_samples(len(q)),
        time_s=2.0 * np.arange(len(q)),
        trajectory=np.concatenate([np.full(len(part), name) for name, part in paths.items()]),
        q_cmd=q,
        markers_px={name: pixels[:, "abcf".index(name)] for name in markers},
        camera=camera,
        arm_plane_z_mm=float(BASE_MM[2]),
        pixel_noise_px=noise_px if declare_noise else None,
        held_out=tuple(name for name in held_out if name in paths),
    )


def gain_of(joint: int, gain: float) -> Bend:
    """Return a servo that turns `gain` times what it is told."""

    def bend(q: Array) -> Array:
        out = q.copy()
        out[:, joint - 1] *= gain
        return out

    return bend
