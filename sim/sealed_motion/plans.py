"""Motions that a bench might run: chirps, steps, staircases, binary noise, trapezoids, slow swings and holds."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from armtwin.models.motion_world import Motion

Array = NDArray[np.float64]

# One joint's commands about zero, of unit size, at times (N,) from zero.
Shape = Callable[[Generator, Array], Array]

_FASTEST_CHIRP_HZ = 2.5


def draw_motions(rng: Generator, n_joints: int, n_rows: int) -> tuple[list[Motion], tuple[str, ...]]:
    """Draw 2 to 8 motions of about `n_rows` rows in all, at 20 to 200 Hz with times that jitter; and those held out."""
    rate_hz = float(np.exp(rng.uniform(np.log(20.0), np.log(200.0))))
    jitter = float(rng.choice([0.0, 0.02, 0.15]))
    count = int(rng.integers(2, 9))
    kinds = [list(SHAPES)[k] for k in rng.permutation(len(SHAPES))] + list(rng.choice(list(SHAPES), size=2))
    lengths = np.maximum(rng.dirichlet(np.full(count, 8.0)) * n_rows, 3.0 * rate_hz).astype(int)
    centre = rng.uniform(-0.3, 0.3, n_joints)
    reach = rng.uniform(0.3, 0.8, n_joints)
    motions, start, numbers = [], float(rng.uniform(0.0, 5.0)), dict.fromkeys(SHAPES, 0)
    for kind, length in zip(kinds[:count], lengths, strict=True):
        numbers[kind] += 1
        time_s = start + (np.arange(length) + jitter * rng.uniform(-0.5, 0.5, length)) / rate_hz
        shapes = [SHAPES[kind](rng, np.arange(length) / rate_hz) for _ in range(n_joints)]
        q = centre + reach * rng.uniform(0.5, 1.0, n_joints) * np.stack(shapes, axis=-1)
        motions.append(Motion(f"{kind}_{numbers[kind]}", time_s, q))
        start = float(time_s[-1] + rng.uniform(0.5, 5.0))
    held_out = (motions[-1].name,) if count < 4 else (motions[-2].name, motions[-1].name)
    return motions, held_out


def _chirp(rng: Generator, t: Array) -> Array:
    fast = rng.uniform(0.8, _FASTEST_CHIRP_HZ)
    slow = rng.uniform(0.1, 0.3)
    phase = 2 * np.pi * (slow * t + 0.5 * (fast - slow) * t**2 / max(t[-1], 1e-9))
    return np.asarray(np.sin(phase + rng.uniform(0, 2 * np.pi)) / (1.0 + 1.5 * t / max(t[-1], 1e-9)))


def _levels(rng: Generator, t: Array, hold_s: tuple[float, float], draw: Callable[[int], Array]) -> Array:
    ends = np.cumsum(rng.uniform(*hold_s, int(t[-1] / hold_s[0]) + 2))
    levels = draw(len(ends) + 1)
    return np.asarray(levels[np.searchsorted(ends, t, side="right")])


def _steps(rng: Generator, t: Array) -> Array:
    return _levels(rng, t, (0.5, 1.5), lambda n: rng.uniform(-1.0, 1.0, n))


def _staircase(rng: Generator, t: Array) -> Array:
    stairs = int(rng.integers(5, 15))
    return _levels(rng, t, (0.25, 0.5), lambda n: 2.0 * np.abs((np.arange(n) / stairs) % 2.0 - 1.0) - 1.0)


def _binary(rng: Generator, t: Array) -> Array:
    size = rng.uniform(0.15, 0.5)
    return _levels(rng, t, (0.15, 0.8), lambda n: size * rng.choice([-1.0, 1.0], n))


def _trapezoids(rng: Generator, t: Array) -> Array:
    ends = np.cumsum(rng.uniform(1.0, 2.5, int(t[-1]) + 3))
    goals = rng.uniform(-1.0, 1.0, len(ends) + 1)
    speed = rng.uniform(0.5, 2.5)
    at, out = goals[0], np.empty_like(t)
    for k, (now, goal) in enumerate(zip(t, goals[np.searchsorted(ends, t, side="right")], strict=True)):
        step = speed * (now - t[k - 1] if k else 0.0)
        at += float(np.clip(goal - at, -step, step))
        out[k] = at
    return out


def _swing(rng: Generator, t: Array) -> Array:
    return np.asarray(np.sin(2 * np.pi * (t / rng.uniform(5.0, 10.0) + rng.uniform())))


def _holds(rng: Generator, t: Array) -> Array:
    return _levels(rng, t, (1.5, 3.0), lambda n: rng.uniform(-1.0, 1.0, n))


SHAPES: dict[str, Shape] = {
    "chirp": _chirp,
    "steps": _steps,
    "staircase": _staircase,
    "binary": _binary,
    "trapezoids": _trapezoids,
    "swing": _swing,
    "holds": _holds,
}
