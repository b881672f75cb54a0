"""A moving twin sent through a plan by MuJoCo, as the log that its arm would give."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from armtwin.models.errors import InputError
from armtwin.models.motion_world import Motion
from armtwin.models.moving_twin import MovingTwin
from armtwin.models.plan import Plan
from armtwin.models.recordings.moving import MovingRecording
from armtwin.sim.motion.twin import simulate_twin_motion

Array = NDArray[np.float64]

# Commands of a plan that has no times of its own are given so often: usual for serial servos.
RATE_HZ = 50.0
# What an encoder of 14 bits leaves of an angle.
NOISE_RAD = 2.0 * np.pi / 2**14 / np.sqrt(12.0)
# The arm rests between motions, as on a bench.
_PAUSE_S = 2.0


def simulate_moving(
    twin: MovingTwin,
    plan: Plan,
    *,
    rate_hz: float = RATE_HZ,
    noise_rad: float | None = None,
    seed: int = 0,
    held_out: tuple[str, ...] = (),
) -> MovingRecording:
    """Return the log of an arm that moves as the twin says; `noise_rad` is the deviation of a reading.

    Commands are given at the plan's own times, or one after another at `rate_hz`, with a pause between motions. Raises
    `InputError` for a plan of other joints, or with masses to hang.
    """
    if plan.q_cmd.shape[1] != twin.arm.n_joints:
        raise InputError(f"the plan commands {plan.q_cmd.shape[1]} joints, the twin has {twin.arm.n_joints}")
    if plan.payload_kg.any():
        raise InputError("column 'payload_kg': nobody hangs a mass while the arm moves; leave it out")
    runs = plan.trajectory[np.append(True, plan.trajectory[1:] != plan.trajectory[:-1])].tolist()
    again = [name for name in runs if runs.count(name) > 1]
    if again:
        raise InputError(f"the plan's trajectory '{again[0]}' begins twice; each is one motion: give the second a name")
    first = np.append(True, plan.trajectory[1:] != plan.trajectory[:-1])
    time_s = plan.time_s
    if time_s is None:
        time_s = np.arange(len(plan)) / rate_hz + _PAUSE_S * (np.cumsum(first) - 1)
    begins = np.flatnonzero(first)
    motions = [
        Motion(str(plan.trajectory[a]), time_s[a:b], plan.q_cmd[a:b])
        for a, b in zip(begins, np.append(begins[1:], len(plan)), strict=True)
    ]
    read = simulate_twin_motion(twin.causes, twin.arm, motions, None, twin.zeros_rad)
    spread = NOISE_RAD if noise_rad is None else noise_rad
    read = read + np.random.default_rng(seed).normal(0.0, spread, read.shape)
    return MovingRecording(twin.declared, time_s, plan.trajectory, plan.q_cmd, read, held_out=held_out)
