"""Logs of a moving arm made without armtwin: three joints in gravity's plane, forward Euler at half a millisecond.

It shares nothing with the estimator or the simulated bench: no formula, no step, no constant but the nominal servo's
time constant and speed that the contract states.
"""

from __future__ import annotations

import csv
import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

LENGTHS_M, MASSES_KG = np.array([0.12, 0.12, 0.06]), np.array([0.09, 0.08, 0.05])
RATE_HZ = 50.0
NOISE_RAD = 3e-4
_TICK_S = 5e-4


@dataclass(frozen=True)
class Faults:
    """What is wrong, joint by joint (from 0); a key is a field of `_SERVO`, or one of those that follow."""

    servo: Mapping[int, Mapping[str, float]] = field(default_factory=dict)
    late: tuple[float, float] | None = None  # from when on, and by how much, s
    repeated: tuple[float, int] | None = None  # from when on only every so many readings are fresh
    gross: tuple[int, int] | None = None  # joint, number of rows
    missed: tuple[int, int] | None = None
    deaf: tuple[int, tuple[tuple[int, int], ...]] | None = None  # joint, runs of rows whose commands it missed
    hung: float = 0.0  # kg at the tip, which no servo is trimmed for: it gives by `give`, rad/(N m)
    breathing: tuple[int, float] | None = None  # joint, amplitude: what no effect explains


_SERVO = {
    "delay": 0.0, "tau": 0.020, "speed": 6.16, "friction": 0.0, "play": 0.0, "droop": 0.0, "gain": 1.0, "stop": 9.0,
    "dead": 0.0, "step": 0.0, "slip": 0.0, "give": 0.0, "bristles": 0.0, "bristles_bend": 1.0,
}  # fmt: skip


def motions(rng: np.random.Generator, seconds: float = 10.0) -> list[tuple[str, Array]]:
    """Return named streams of commands, (N, 3) rad: a chirp, steps, slow swings, a staircase."""
    t = np.arange(0.0, seconds, 1.0 / RATE_HZ)[:, None]
    phase = rng.uniform(0, 6, 3)
    chirp = 0.35 * np.sin(2 * np.pi * (0.1 * t + 0.06 * t**2) + phase)
    levels = rng.uniform(-0.6, 0.6, (int(seconds / 0.9) + 1, 3))
    steps = levels[(t[:, 0] / 0.9).astype(int)]
    slow = 0.7 * np.sin(2 * np.pi * np.array([0.11, 0.16, 0.21]) * t + phase)
    stairs = 0.06 * np.floor(np.abs((t / 0.6) % 16 - 8)) + np.array([-0.2, 0.0, 0.1])
    return [("chirp", chirp), ("steps", steps), ("slow", slow), ("stairs", stairs)]


def write_log(folder: Path, seed: int, faults: Faults, grain_rad: float = 0.0, *, seconds: float = 10.0) -> Path:
    """Write a recording of the contract and return its folder."""
    rng = np.random.default_rng(seed)
    named = motions(rng, seconds)
    sent = np.concatenate([q for _, q in named])
    names = np.repeat([name for name, _ in named], [len(q) for _, q in named])
    time = np.arange(len(sent)) / RATE_HZ + 1.3 * np.cumsum(np.append(False, names[1:] != names[:-1]))
    time = time + rng.uniform(-0.1, 0.1, len(time)) / RATE_HZ
    time -= time[0]
    measured = _follow(rng, time, names, sent, faults) + rng.uniform(-0.02, 0.02, 3)
    measured += rng.normal(0.0, NOISE_RAD, measured.shape)
    if faults.gross is not None:
        joint, count = faults.gross
        measured[rng.choice(len(time), count, replace=False), joint] += rng.choice([-0.2, 0.3], count)
    if faults.repeated is not None:
        measured = measured[_every(time, *faults.repeated)]
    if grain_rad:
        measured = np.round(measured / grain_rad) * grain_rad
    folder.mkdir(parents=True)
    header = {
        "schema": "armtwin.recording/1",
        "motion": "moving",
        "arm": {
            "name": "planar",
            "link_lengths_mm": (1e3 * LENGTHS_M).tolist(),
            "gravity_m_s2": [0.0, -9.81],
            "link_masses_kg": MASSES_KG.tolist(),
        },
    }
    (folder / "recording.json").write_text(json.dumps(header), "utf-8")
    columns = ["sample", "time_s", "trajectory"]
    columns += [f"theta{j}_{kind}_rad" for kind in ("cmd", "meas") for j in (1, 2, 3)]
    with (folder / "samples.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(columns)
        for row in range(len(time)):
            writer.writerow([row, f"{time[row]:.5f}", names[row], *sent[row].round(6), *measured[row].round(6)])
    return folder


def _weight(q: Array) -> Array:
    """(3,) torque that holds the arm at angles (3,), N m: masses hang at the middles of their links."""
    x = LENGTHS_M * np.cos(np.cumsum(q))
    axes = np.append(0.0, np.cumsum(x)[:-1])
    middles = axes + x / 2
    return np.array([9.81 * float((MASSES_KG[j:] * (middles[j:] - axes[j])).sum()) for j in range(3)])


def _tip(q: Array) -> Array:
    """(3,) torque that holds a kilogram at the tip, N m."""
    x = LENGTHS_M * np.cos(np.cumsum(q))
    return np.array([9.81 * float(x[j:].sum()) for j in range(3)])


def _follow(rng: np.random.Generator, time: Array, names: Any, sent: Array, faults: Faults) -> Array:
    values: dict[str, Array] = {key: np.full(3, value) for key, value in _SERVO.items()}
    for joint, own in faults.servo.items():
        for key, value in own.items():
            values[key][joint] = value
    heard = _heard(rng, sent, values, faults)
    rub = np.zeros(3)
    out = np.empty_like(sent)
    x = y = heard[0].copy()
    middle = time[len(time) // 2]
    for row in range(len(time)):
        if row == 0 or names[row] != names[row - 1]:
            x = np.minimum(heard[max(row - 1, 0)], values["stop"])
            y = x.copy()
        else:
            ticks = max(1, round((time[row] - time[row - 1]) / _TICK_S))
            tick = (time[row] - time[row - 1]) / ticks
            load = _weight(x)
            pull_of_tip = faults.hung * _tip(x)
            for k in range(ticks):
                now = time[row - 1] + k * tick
                delay = values["delay"] + (faults.late[1] if faults.late and now >= faults.late[0] else 0.0)
                command = heard[row - 1]
                if delay.any():
                    at = np.maximum(np.searchsorted(time, now - delay, side="right") - 1, 0)
                    command = heard[at, np.arange(3)]
                error = command - x - values["droop"] * load - values["give"] * pull_of_tip - rub
                pull = np.sign(error) * np.maximum(np.abs(error) - values["friction"], 0.0)
                way = tick * np.clip(pull / values["tau"], -values["speed"], values["speed"])
                x = np.minimum(x + way, values["stop"])
                # Dahl's friction: it bends by so many radians of the shaft before it slides
                rub = rub + (np.sign(way) * values["bristles"] - rub) * np.abs(way) / values["bristles_bend"]
                y = np.clip(y, x - values["play"] / 2, x + values["play"] / 2)
        out[row] = y + np.where(time[row] >= middle, values["slip"], 0.0)
    if faults.breathing is not None:
        joint, size = faults.breathing
        out[:, joint] += size * np.sin(2 * np.pi * time / 3.7)
    return out


def _every(time: Array, from_s: float, held: int) -> Array:
    """(N,) the row whose command or reading stands in each row."""
    rows, first = np.arange(len(time)), int(np.argmax(time >= from_s))
    return np.where(rows >= first, first + (rows - first) // held * held, rows)


def _heard(rng: np.random.Generator, sent: Array, values: Mapping[str, Array], faults: Faults) -> Array:
    heard = sent.copy()
    if faults.missed is not None:
        joint, count = faults.missed
        steps = np.abs(np.diff(sent[:, joint], prepend=sent[0, joint]))
        for row in np.sort(rng.choice(np.flatnonzero(steps > 0.03), count, replace=False)):
            heard[row, joint] = heard[row - 1, joint]
    if faults.deaf is not None:
        joint, runs = faults.deaf
        for first, last in runs:
            heard[first:last, joint] = heard[first - 1, joint]
    for joint in range(3):
        step, dead = values["step"][joint], values["dead"][joint]
        if step:
            heard[:, joint] = (np.floor(heard[:, joint] / step - 0.3) + 0.5 + 0.3) * step
        if dead:
            last = heard[0, joint]
            for row in range(len(heard)):
                if abs(heard[row, joint] - last) > dead:
                    last = heard[row, joint]
                heard[row, joint] = last
    out: Array = values["gain"] * heard
    return out
