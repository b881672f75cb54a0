"""The log of somebody else's arm: six serial servos about a hobby arm, each a spring, a damper and dry friction.

It shares nothing with the estimator, the simulated bench or the other generators: torques and inertias, a trapezoidal
move of the host, a bus that is read joint after joint, counts of 4096 to a turn.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

JOINTS = ("shoulder_pan", "shoulder_lift", "elbow_flex", "wrist_flex", "wrist_roll", "gripper")
COUNT_RAD = 2.0 * np.pi / 4096.0
_TICK_S = 1e-3


@dataclass(frozen=True, eq=False)
class Servos:
    """What the servos are, one value a joint: stiffness N m/rad, damping N m s/rad, inertia kg m2, friction N m.

    `late_s` passes until a command acts; a joint is read `read_s` after the one before it.
    """

    stiffness: Array
    damping: Array
    inertia: Array
    friction: Array
    late_s: float
    read_s: float = 0.002


def usual(joints: int = 6) -> Servos:
    """Return servos with a lag of 60 to 90 ms, friction of a degree and 40 ms of latency."""
    stiffness = np.array([4.0, 5.0, 4.5, 2.0, 1.5, 1.5])[:joints]
    lag_s = np.array([0.06, 0.09, 0.08, 0.06, 0.06, 0.05])[:joints]
    friction_rad = np.array([0.010, 0.025, 0.018, 0.012, 0.008, 0.010])[:joints]
    return Servos(stiffness, lag_s * stiffness, 0.0004 * stiffness, friction_rad * stiffness, 0.04)


@dataclass(frozen=True, eq=False)
class Stream:
    """One motion: when each cycle began, what was sent in it and what was read before that, rad."""

    name: str
    time_s: Array
    sent: Array
    read: Array


def streams(
    servos: Servos, rate_hz: float = 50.0, seconds: float = 12.0, seed: int = 0, jitter: float = 0.05
) -> list[Stream]:
    """Return four motions: swings that grow quicker, steps, slow turns and moves with ramps."""
    rng = np.random.default_rng(seed)
    n = len(servos.stiffness)
    cycles = int(seconds * rate_hz)
    out = []
    for number, name in enumerate(("swings", "steps", "slow", "ramps")):
        ideal = np.arange(cycles) / rate_hz
        time = ideal + jitter / rate_hz * rng.uniform(-1, 1, cycles)
        sent = np.stack([_wanted(name, ideal, rng) for _ in range(n)], axis=1)
        out.append(Stream(name, time + 30.0 * number, sent, _read(servos, time, sent)))
    return out


def _wanted(name: str, t: Array, rng: np.random.Generator) -> Array:
    size, phase = rng.uniform(0.35, 0.6), rng.uniform(0, 6)
    if name == "swings":
        return size * np.sin(2 * np.pi * (0.15 + 0.05 * t) * t + phase)
    if name == "slow":
        return 1.4 * size * np.sin(2 * np.pi * rng.uniform(0.12, 0.2) * t + phase)
    levels = rng.uniform(-size, size, int(t[-1] / 0.8) + 3)
    number = (t / 0.8).astype(int)
    if name == "steps":
        return np.asarray(levels[number])
    way = np.clip((t / 0.8 - number) / 0.7, 0.0, 1.0)
    return np.asarray(levels[number] + (levels[number + 1] - levels[number]) * way)


def _read(servos: Servos, time: Array, sent: Array) -> Array:
    """Step the servos through a motion and return the joints in whole counts, each read at its turn."""
    n = sent.shape[1]
    angle, speed = sent[0].copy(), np.zeros(n)
    out = np.empty_like(sent)
    reading = time[:, None] + servos.read_s * np.arange(n)
    acts = time + servos.read_s * n + servos.late_s
    ticks = np.arange(time[0], reading[-1, -1] + 2 * _TICK_S, _TICK_S)
    heard = np.maximum(np.searchsorted(acts, ticks, side="right") - 1, 0)
    following = np.zeros(n, dtype=int)
    for tick, command in zip(ticks, heard, strict=True):
        for joint in np.flatnonzero(reading[np.minimum(following, len(time) - 1), np.arange(n)] <= tick):
            if following[joint] < len(time):
                out[following[joint], joint] = angle[joint]
                following[joint] += 1
        drive = servos.stiffness * (sent[command] - angle)
        free = (servos.inertia * speed + _TICK_S * drive) / (servos.inertia + _TICK_S * servos.damping)
        most = _TICK_S * servos.friction / (servos.inertia + _TICK_S * servos.damping)
        speed = np.sign(free) * np.maximum(np.abs(free) - most, 0.0)
        angle = angle + _TICK_S * speed
    return np.asarray(np.round(out / COUNT_RAD) * COUNT_RAD)


def together(motions: Sequence[Stream]) -> tuple[Array, NDArray[np.str_], Array, Array]:
    """Return times (N,), names (N,), what was sent and what was read (N, n) of all motions."""
    names = np.repeat([one.name for one in motions], [len(one.time_s) for one in motions])
    stacked = (np.concatenate([getattr(one, key) for one in motions]) for key in ("time_s", "sent", "read"))
    time, sent, read = stacked
    return time, names, sent, read
