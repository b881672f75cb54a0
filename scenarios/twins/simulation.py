"""A twin run through a plan, as a recording."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from armtwin.models.atomic import folder_aside
from armtwin.models.errors import InputError
from armtwin.models.plan import Plan
from armtwin.models.recordings.recording import Recording
from armtwin.models.recordings.writer import write_recording
from armtwin.models.twin import Twin, rebuild
from armtwin.models.world import POSE_PERIOD_S
from armtwin.scenarios.runner.frames import write_frame
from armtwin.sim.bench import SimulatedBench
from armtwin.sim.observe import make_angle_recording, make_recording
from armtwin.sim.physics.simulation import default_clock

# What the sub-pixel detector leaves of a good picture, px, and what a careful hand reads off a protractor, rad.
NOISE_PX = 0.06
NOISE_RAD = 1e-3


def simulate(
    twin: Twin, plan: Plan, *, noise: float | None = None, seed: int = 0, held_out: tuple[str, ...] = ()
) -> Recording:
    """Return what a bench would record that is as the twin says, one pose every 1.5 s.

    `noise` is the standard deviation of a pixel coordinate, or of an angle, rad, for a twin without camera.
    """
    world, rng = rebuild(twin), np.random.default_rng(seed)
    clock = default_clock(len(plan), POSE_PERIOD_S)
    payload = plan.payload_kg if plan.payload_kg.any() else None
    if twin.camera is None:
        spread = NOISE_RAD if noise is None else noise
        return make_angle_recording(
            world, plan.q_cmd, plan.trajectory, clock, rng, spread, held_out=held_out, payload_kg=payload
        )
    spread = NOISE_PX if noise is None else noise
    return make_recording(
        world,
        plan.q_cmd,
        plan.trajectory,
        clock,
        rng,
        spread,
        held_out=held_out,
        payload_kg=payload,
        declare_noise=spread > 0,
    )


def write_simulation(
    folder: Path,
    twin: Twin,
    plan: Plan,
    recording: Recording,
    *,
    frames: bool = False,
    seed: int = 0,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> None:
    """Write the recording, with a picture of every pose where `frames` are wanted; raises `InputError` without camera.

    The folder appears when all of it is there.
    """
    if frames and twin.camera is None:
        raise InputError("--frames: the twin has no camera; it was made from joint angles alone")
    with folder_aside(folder) as aside:
        write_recording(aside, recording)
        if frames:
            world = replace(rebuild(twin), detections=())
            with SimulatedBench(world, seed=seed, n_poses=len(plan)) as bench:
                for row, q in enumerate(plan.q_cmd):
                    bench.hang(float(plan.payload_kg[row]))
                    bench.move(q)
                    write_frame(aside / "frames", int(recording.sample[row]), bench.capture().image)
                    progress(row + 1, len(plan))
