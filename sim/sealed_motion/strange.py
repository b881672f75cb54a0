"""Faults of a moving arm that no effect of the catalogue describes: the right answer to them is `unknown`."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import mujoco
import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from armtwin.models.motion_world import Disturbance, MotionWorld, Wire

Array = NDArray[np.float64]

# Makes a fault of `size` times its usual size at a joint (index from 0).
Strange = Callable[[Generator, MotionWorld, int, float], MotionWorld]

# Inertia of what swings on an elastic link, kg m2: small against a drive of 50,000 N m/rad, large against any link.
_SWINGING_KG_M2 = 0.5
_DAMPING_RATIO = 0.06


def resonance(rng: Generator, world: MotionWorld, index: int, size: float) -> MotionWorld:
    """A link that swings on an elastic gear; the encoder sits behind it."""
    joint, hertz = world.arm.joints[index], rng.uniform(2.5, 5.0) / np.sqrt(size)
    stiffness = _SWINGING_KG_M2 * (2 * np.pi * hertz) ** 2

    def mechanism(spec: mujoco.MjSpec, scale: float) -> None:
        drive = spec.joint(joint)
        flex = drive.parent.add_joint(name=f"flex_{joint}", axis=drive.axis, pos=drive.pos)
        flex.stiffness[0] = stiffness
        flex.damping[0] = 2 * _DAMPING_RATIO * np.sqrt(stiffness * _SWINGING_KG_M2)
        link = spec.add_tendon(name=f"swinging_{joint}")  # its length is the link's angle against the frame
        link.wrap_joint(joint, 1.0)
        link.wrap_joint(f"flex_{joint}", 1.0)
        link.armature = _SWINGING_KG_M2

    return world.with_mechanism(mechanism).with_series_hinge(index, f"flex_{joint}")


def hum(rng: Generator, world: MotionWorld, index: int, size: float) -> MotionWorld:
    """Something shakes the drive with a rhythm of its own."""
    hertz, amplitude, phase = rng.uniform(0.3, 2.5), size * rng.uniform(0.004, 0.012), rng.uniform(0, 2 * np.pi)

    def shaken() -> Disturbance:
        def push(time_s: float, q: Array, speed: Array, target: Array) -> Array:
            out = np.zeros(len(q))
            out[index] = amplitude * np.sin(2 * np.pi * hertz * time_s + phase)
            return out

        return push

    return world.with_disturbance(shaken)


def supply_sag(rng: Generator, world: MotionWorld, index: int, size: float) -> MotionWorld:
    """The supply gives way where the other joints move: this joint's loop is weaker meanwhile."""
    share = size * rng.uniform(0.15, 0.35)
    others = np.arange(world.arm.n_joints) != index if world.arm.n_joints > 1 else np.ones(1, dtype=bool)

    def sagging() -> Disturbance:
        def push(time_s: float, q: Array, speed: Array, target: Array) -> Array:
            out = np.zeros(len(q))
            lost = min(share * float(np.abs(speed[others]).sum()), 0.9)
            out[index] = -lost * (target[index] - q[index])
            return out

        return push

    return world.with_disturbance(sagging)


def crosstalk(rng: Generator, world: MotionWorld, index: int, size: float) -> MotionWorld:
    """A neighbour's signal wire couples into this one's; of a single joint the wire hears its own command of before."""
    n = world.arm.n_joints
    other, share = (index + 1) % n, min(size * rng.uniform(0.04, 0.1), 0.6) * (1.0 if rng.random() < 0.5 else -1.0)

    def coupled(wires: Sequence[Wire]) -> list[Wire]:
        out = list(wires)
        mine, neighbour = wires[index], wires[other]
        late = np.searchsorted(neighbour.time_s, mine.time_s - (0.4 if n == 1 else 0.0), side="right") - 1
        out[index] = Wire(mine.time_s, mine.q + share * neighbour.q[np.maximum(late, 0)], mine.row)
        return out

    return world.with_wiring(coupled)


def windup(rng: Generator, world: MotionWorld, index: int, size: float) -> MotionWorld:
    """An integral part without a bound that is worth it: it winds up on the way and overshoots."""
    rate, most = min(size * rng.uniform(1.5, 4.0), 12.0), size * rng.uniform(0.05, 0.12)

    def integral() -> Disturbance:
        wound, before = 0.0, None

        def push(time_s: float, q: Array, speed: Array, target: Array) -> Array:
            nonlocal wound, before
            passed = 0.0 if before is None else max(time_s - before, 0.0)
            before = time_s
            wound = float(np.clip(wound + rate * passed * (target[index] - q[index]), -most, most))
            out = np.zeros(len(q))
            out[index] = wound
            return out

        return push

    return world.with_disturbance(integral)


def wandering(rng: Generator, world: MotionWorld, index: int, size: float) -> MotionWorld:
    """A zero that wanders to and fro at random, over seconds."""
    knots = size * rng.uniform(0.006, 0.015) * rng.standard_normal(400)
    every = rng.uniform(1.5, 4.0)

    def mount() -> Disturbance:
        def push(time_s: float, q: Array, speed: Array, target: Array) -> Array:
            out = np.zeros(len(q))
            out[index] = np.interp(time_s / every, np.arange(len(knots)), knots)
            return out

        return push

    return world.with_disturbance(mount)


STRANGE: dict[str, Strange] = {
    "resonance": resonance,
    "hum": hum,
    "supply_sag": supply_sag,
    "crosstalk": crosstalk,
    "windup": windup,
    "wandering": wandering,
}
