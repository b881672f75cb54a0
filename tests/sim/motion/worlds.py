"""Moving arms for tests."""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from armtwin.models.arm import Arm
from armtwin.models.catalogue.motion_injection import inject_in_motion
from armtwin.models.catalogue.site import Site
from armtwin.models.motion_arm import MotionArm, model_arm, planar_arm
from armtwin.models.motion_world import Motion, MotionWorld, ideal_motion_world
from armtwin.sim.motion.simulation import simulate_motion

Array = NDArray[np.float64]

NOMINAL_TIME_S = 0.020
NOMINAL_SPEED_RAD_S = 6.16

TWO_AXES = """<mujoco><compiler angle="radian"/><worldbody><body name="base">
  <inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>
  <body name="turret"><joint name="yaw" axis="0 0 1" range="-0.1 0.1"/>
    <inertial pos="0 0 0.05" mass="0.2" diaginertia="1e-4 1e-4 1e-4"/>
    <body name="arm" pos="0 0 0.1"><joint name="pitch" axis="0 1 0" damping="3"/>
      <inertial pos="0.1 0 0" mass="0.2" diaginertia="1e-4 7e-4 7e-4"/>
      <body name="jaw" pos="0.2 0 0"><joint name="jaw"/>
        <inertial pos="0 0 0" mass="0.01" diaginertia="1e-6 1e-6 1e-6"/></body></body></body></body></worldbody>
<actuator><position joint="yaw" kp="5"/></actuator></mujoco>"""


def upright(n: int = 3) -> MotionArm:
    return planar_arm(Arm("chain", np.linspace(120.0, 60.0, n), np.array([0.0, -9.81])))


def two_axes(folder: Path) -> MotionArm:
    (folder / "two.xml").write_text(TWO_AXES)
    return model_arm("two", folder / "two.xml", ("yaw", "pitch"))


def swing(n: int, seconds: float = 4.0, rate_hz: float = 100.0, size: float = 0.5) -> Motion:
    """All joints there and back at even speed, once in 4 s: size / s rad/s."""
    time_s = np.arange(0.0, seconds, 1.0 / rate_hz)
    q = size * (2.0 * np.abs((time_s / 4.0) % 1.0 * 2.0 - 1.0) - 1.0)
    return Motion("swing", time_s, np.repeat(q[:, None], n, axis=1))


def steps(n: int, sizes: tuple[float, ...] = (0.0, 0.5, 0.0, 0.05), rate_hz: float = 100.0) -> Motion:
    """All joints to each of the angles, where they stay for 2 s."""
    q = np.repeat(np.array(sizes), round(2.0 * rate_hz))
    return Motion("steps", np.arange(len(q)) / rate_hz, np.repeat(q[:, None], n, axis=1))


def moved(name: str, motion: Motion, joint: int | None = 2, **parameters: Any) -> Array:
    """(N, n) what an effect changes of an upright arm's readings."""
    world = ideal_motion_world(upright())
    faulty = inject_in_motion(world, name, parameters, Site(joint=joint))
    return run(faulty, motion) - run(world, motion)


def run(world: MotionWorld, *motions: Motion) -> Array:
    return simulate_motion(world, motions)


def followed(motion: Motion) -> Array:
    """(N, n) a lag of 20 ms and a speed of at most 6.16 rad/s, in steps of 50 us."""
    q, out = motion.q_cmd[0].copy(), np.empty_like(motion.q_cmd)
    for k, command in enumerate(motion.q_cmd):
        out[k] = q
        span = motion.time_s[k + 1] - motion.time_s[k] if k + 1 < len(out) else 0.0
        n = max(1, round(span / 5e-5))
        for _ in range(n):
            reach = NOMINAL_SPEED_RAD_S * span / n
            q = q + np.clip((command - q) * (1 - np.exp(-span / n / NOMINAL_TIME_S)), -reach, reach)
    return out
