"""Recordings of faults in forms that real parts have, made by a bench that shares nothing with the project.

Plain NumPy with its own chain, lens and clock: what it has in common with armtwin is the recording's format alone,
so it tells whether a fault is found whatever form a part gives it. Poses, noises and sizes differ from those of sealed
worlds; neither the noise nor held-out trajectories are declared. Each fault says what has to be named, and where.

    expected = write_recording(folder, ("lag_constant_speed",), seed)
"""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

Array = NDArray[np.float64]

# The paper's arm and camera (Tables 1 and 2), stated in each recording.
_LENGTHS_MM = np.array([120.0, 121.7, 38.0, 6.73])
_FOCAL_PX = np.array([1438.6, 1439.1])
_CENTRE_PX = np.array([654.2, 369.7])
_LENS = (0.163, 0.0428, 0.0064, 0.0016, -2.1819)
_ROTATION = np.array(
    [
        [-0.9987570146585288, 0.004081883004346495, 0.049676593094953564],
        [-0.0047177820371684595, -0.9999083456811704, -0.012690262794527523],
        [0.04962023985262994, -0.012908852322465912, 0.99868473169899],
    ]
)
_SHIFT_MM = np.array([118.6608, 41.34, 565.437])
_PLANE_MM = -80.87
_BASE_MM = np.array([40.0, -33.0])
_DEGREE = np.pi / 180.0


@dataclass
class Bench:
    """What happens on the bench: commands (N, 3) rad, when each was seen (N,) s, temperature (N,) C, the true arm."""

    q: Array
    time_s: Array
    celsius: Array
    upright: bool
    lengths_mm: Array
    torque_nm: Callable[[Array], Array]


@dataclass
class Expected:
    """What a diagnosis has to name, each an effect with its joint (None: of the whole arm); other names also right."""

    causes: list[tuple[str, int | None]] = field(default_factory=list)
    allowed: tuple[str, ...] = ()


Fault = Callable[[Bench, Array, Generator], tuple[Array, Expected]]


def write_recording(folder: Path, names: tuple[str, ...], seed: int, n: int = 150) -> Expected:
    """Write a recording with faults (names of `FORMS`) to a folder, and return what is to be said of it."""
    rng = np.random.default_rng([seed, *"+".join(names).encode()])
    bench = _bench(rng, n, upright="spring_stiffening" in names or rng.random() < 0.5)
    q, expected = bench.q.copy(), Expected()
    for name in sorted(names, key=lambda one: list(FORMS).index(one)):
        q, told = FORMS[name](bench, q, rng)
        expected.causes += told.causes
        expected.allowed += told.allowed
    pixels = _pixels(_points(q + rng.uniform(-0.06, 0.06, 3), bench.lengths_mm + rng.uniform(-2.0, 2.0, 4), rng))
    pixels += _noise(rng, pixels.shape)
    _write(folder, bench, pixels, with_heat="drift_temperature" in names)
    return expected


# --- the bench ---


def _bench(rng: Generator, n: int, upright: bool) -> Bench:
    blocks: list[Array] = []
    makers = [_random_walk, _zigzag, _pick_and_place, _spiral, _ladder]
    order = rng.permutation(len(makers))
    for index in order:
        blocks.append(makers[index](rng, n // len(makers)))
    q = np.concatenate(blocks)
    time_s = np.cumsum(rng.uniform(0.9, 1.1, len(q)) * rng.uniform(0.8, 4.0))
    hours = (time_s - time_s[0]) / time_s[-1]
    celsius = 21.0 + 9.0 * np.sin(2.2 * hours) + 2.0 * np.sin(9.0 * hours)
    return Bench(q, time_s, celsius, upright, _LENGTHS_MM, _torque)


def _random_walk(rng: Generator, n: int) -> Array:
    q = np.zeros((n, 3))
    for row in range(1, n):
        q[row] = np.clip(q[row - 1] + rng.normal(0.0, 0.12, 3), [-0.42, -0.32, -0.75], [0.32, 0.42, 0.75])
    return q


def _zigzag(rng: Generator, n: int) -> Array:
    """One joint after the other to and fro, over growing ways."""
    q = np.tile(rng.uniform(-0.15, 0.15, 3), (n, 1))
    for joint, rows in enumerate(np.array_split(np.arange(n), 3)):
        t = np.arange(len(rows)) / max(len(rows) - 1, 1)
        q[rows, joint] = 0.4 * (0.3 + 0.7 * t) * (2 / np.pi) * np.arcsin(np.sin(2 * np.pi * 2.5 * t))
    return q


def _pick_and_place(rng: Generator, n: int) -> Array:
    """Between a few places, each approached from wherever the arm was, with a stop on the way."""
    places = rng.uniform([-0.4, -0.3, -0.7], [0.3, 0.4, 0.7], (5, 3))
    stops = places[rng.integers(0, 5, n)]
    stops[1::2] = 0.5 * (stops[:-1:2][: len(stops[1::2])] + stops[1::2])
    return stops


def _spiral(rng: Generator, n: int) -> Array:
    t = np.linspace(0.0, 1.0, n)
    turns = 2 * np.pi * rng.uniform(1.5, 3.0) * t
    return np.stack([0.3 * t * np.cos(turns), 0.3 * t * np.sin(turns), 0.6 * t * np.cos(0.7 * turns + 1.0)], axis=-1)


def _ladder(rng: Generator, n: int) -> Array:
    """All joints up in uneven rungs and down again."""
    rungs = np.cumsum(rng.uniform(0.2, 1.8, n))
    up = np.interp(rungs, [0.0, rungs[-1] / 2, rungs[-1]], [-1.0, 1.0, -1.0])
    return up[:, None] * np.array([0.3, -0.28, 0.6]) * rng.choice([-1.0, 1.0], 3)


def _points(q: Array, lengths: Array, rng: Generator) -> Array:
    """(N, 4, 2) axes A, B, C and tip F in the robot frame, mm, by rotation matrices' first columns."""
    a1 = q[:, 0] + np.pi / 2
    a2 = a1 + q[:, 1] + np.pi / 2
    a3 = a2 + q[:, 2] + np.pi / 2
    b = lengths[0] * np.stack([np.cos(a1), np.sin(a1)], -1)
    c = b + lengths[1] * np.stack([np.cos(a2), np.sin(a2)], -1)
    f = c + lengths[2] * np.stack([np.cos(a3), np.sin(a3)], -1) + lengths[3] * np.stack([np.sin(a3), -np.cos(a3)], -1)
    return np.stack([np.zeros_like(b), b, c, f], axis=1) + rng.uniform(-5.0, 5.0, 2)


def _pixels(points: Array) -> Array:
    """(N, 4, 2) pixels through the paper's camera and lens."""
    board = np.stack(
        [_BASE_MM[0] - points[..., 0], _BASE_MM[1] + points[..., 1], np.full(points.shape[:2], _PLANE_MM)], -1
    )
    seen = board @ _ROTATION.T + _SHIFT_MM
    x, y = seen[..., 0] / seen[..., 2], seen[..., 1] / seen[..., 2]
    k1, k2, p1, p2, k3 = _LENS
    s = x * x + y * y
    radial = 1 + s * (k1 + s * (k2 + s * k3))
    u = x * radial + 2 * p1 * x * y + p2 * (s + 2 * x * x)
    v = y * radial + p1 * (s + 2 * y * y) + 2 * p2 * x * y
    return np.stack([u, v], -1) * _FOCAL_PX + _CENTRE_PX


def _torque(q: Array) -> Array:
    """(N, 3) static torque of gravity on 45 g links with 20 g at the tip, N m."""
    a1 = q[:, 0] + np.pi / 2
    a2 = a1 + q[:, 1] + np.pi / 2
    a3 = a2 + q[:, 2] + np.pi / 2
    x1, x2, x3 = 0.12 * np.cos(a1), 0.1217 * np.cos(a2), 0.038 * np.cos(a3) + 0.00673 * np.sin(a3)
    g = 9.81
    t3 = x3 * (0.030 / 2 + 0.020)
    t2 = x2 * (0.045 / 2 + 0.050) + t3
    t1 = x1 * (0.045 / 2 + 0.095) + t2
    return -g * np.stack([t1, t2, t3], -1)


def _noise(rng: Generator, shape: tuple[int, ...]) -> Array:
    """Noise of a detector, px: bell-shaped, with longer tails, or of a whole frame that shakes a little."""
    size = float(np.exp(rng.uniform(np.log(0.04), np.log(0.2))))
    kind = rng.integers(0, 3)
    if kind == 0:
        return size * rng.standard_normal(shape)
    if kind == 1:
        return size * rng.standard_t(8, shape) / np.sqrt(8 / 6)
    return size * (0.98 * rng.standard_normal(shape) + 0.2 * rng.standard_normal((shape[0], 1, 2)))


def _write(folder: Path, bench: Bench, pixels: Array, with_heat: bool) -> None:
    table: dict[str, Any] = {
        "schema": "armtwin.recording/1",
        "arm": {
            "name": "planar3",
            "link_lengths_mm": _LENGTHS_MM.tolist(),
            "gravity_m_s2": [0.0, -9.81 if bench.upright else 0.0],
            "link_masses_kg": [0.045, 0.045, 0.030],
            "tip_mass_kg": 0.020,
        },
        "camera": {
            "image_width": 1280,
            "image_height": 720,
            "camera_matrix": [[_FOCAL_PX[0], 0, _CENTRE_PX[0]], [0, _FOCAL_PX[1], _CENTRE_PX[1]], [0, 0, 1]],
            "distortion_model": "plumb_bob",
            "distortion_coefficients": list(_LENS),
            "board_to_camera_rotation": _ROTATION.tolist(),
            "board_to_camera_translation_mm": _SHIFT_MM.tolist(),
        },
        "arm_plane_z_mm": _PLANE_MM,
    }
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "recording.json").write_text(json.dumps(table), "utf-8")
    columns = ["sample", "time_s", "trajectory", *(f"theta{j}_cmd_rad" for j in (1, 2, 3))]
    columns += [f"{m}_{axis}_px" for m in "abcf" for axis in "uv"] + (["temperature_c"] if with_heat else [])
    lines = [",".join(columns)]
    inside = ((pixels >= 0) & (pixels <= [1279, 719])).all(axis=-1)
    block = max(1, len(pixels) // 5)
    for row in range(len(pixels)):
        cells = [str(row), f"{bench.time_s[row]:.3f}", f"part{min(row // block, 4)}"]
        cells += [f"{angle:.9f}" for angle in bench.q[row]]
        for marker in range(4):
            cells += [f"{p:.4f}" if inside[row, marker] else "" for p in pixels[row, marker]]
        lines.append(",".join([*cells, *([f"{bench.celsius[row]:.2f}"] if with_heat else [])]))
    (folder / "samples.csv").write_text("\n".join(lines) + "\n", "utf-8")


# --- the faults: each maps angles (N, 3) that the arm was to take to those it took ---


def _one(rng: Generator) -> int:
    return int(rng.integers(0, 3))


def _moves(path: Array) -> Array:
    return np.diff(path, prepend=path[0])


def whole_degrees_trimmed(bench: Bench, q: Array, rng: Generator) -> tuple[Array, Expected]:
    """Servo.write() of whole degrees about zeros that were trimmed one by one: one step, three origins."""
    step, trim = float(rng.choice([1.0, 2.0, 0.5])) * _DEGREE, rng.uniform(-0.5, 0.5, 3)
    return (np.floor(q / step + trim + 0.5) - trim) * step, Expected([("quantization", None)])


def microseconds(bench: Bench, q: Array, rng: Generator) -> tuple[Array, Expected]:
    """Pulses of several microseconds at each servo's own scale about its own middle."""
    scale = rng.uniform(9.0, 12.0, 3) / _DEGREE  # us per rad
    tick = float(rng.choice([8.0, 10.0, 20.0]))
    middle = rng.uniform(1450.0, 1550.0, 3)
    return (np.round((middle + scale * q) / tick) * tick - middle) / scale, Expected([("quantization", None)])


def truncated_counts(bench: Bench, q: Array, rng: Generator) -> tuple[Array, Expected]:
    """An 8-bit register on one or two joints, rounded down."""
    turn = np.pi / 255
    out = q.copy()
    for joint in rng.permutation(3)[: int(rng.integers(1, 3))]:
        out[:, joint] = np.floor((q[:, joint] + np.pi / 2) / turn) * turn - np.pi / 2
    return out, Expected([("quantization", None)])


def lag_constant_speed(bench: Bench, q: Array, rng: Generator) -> tuple[Array, Expected]:
    """A servo of constant speed, photographed after a fixed time: long moves have not arrived."""
    reach = rng.uniform(0.08, 0.2)  # rad before the picture
    return _slewed(q, reach, reach * rng.uniform(1.0, 1.5)), Expected([("settling_lag", None)])


def lag_speed_and_tail(bench: Bench, q: Array, rng: Generator) -> tuple[Array, Expected]:
    """Constant speed far off, then a share of what is left: a proportional loop whose output saturates."""
    left, reach = rng.uniform(0.1, 0.4), rng.uniform(0.1, 0.25)
    out, at = q.copy(), q[0].copy()
    for row in range(1, len(q)):
        gap = q[row] - at
        run = np.clip(gap * (1 - left), -reach, reach)
        at = out[row] = at + run
    return out, Expected([("settling_lag", None)])


def lag_share(bench: Bench, q: Array, rng: Generator) -> tuple[Array, Expected]:
    """A share of each move is left, another at each joint; the arm arrives before the next command."""
    left = rng.uniform(0.02, 0.15, 3)
    before = np.concatenate([q[:1], q[:-1]])
    return q - left * (q - before), Expected([("settling_lag", None)])


def _slewed(q: Array, seen: float, until_next: float) -> Array:
    out, at = q.copy(), q[0].copy()
    for row in range(1, len(q)):
        gap = q[row] - at
        out[row] = at + np.clip(gap, -seen, seen)
        at = at + np.clip(gap, -until_next, until_next)
    return out


def slips_repeatedly(bench: Bench, q: Array, rng: Generator) -> tuple[Array, Expected]:
    """A horn that slips two to four times, each by another angle."""
    joint, out = _one(rng), q.copy()
    for row in _apart(rng, len(q), int(rng.integers(2, 5))):
        out[row:, joint] += rng.choice([-1, 1]) * rng.uniform(0.02, 0.08)
    return out, Expected([("joint_slip", joint + 1)])


def slips_and_back(bench: Bench, q: Array, rng: Generator) -> tuple[Array, Expected]:
    """A horn that slips and snaps back."""
    joint, out = _one(rng), q.copy()
    first, second = _apart(rng, len(q), 2)
    out[first:second, joint] += rng.choice([-1, 1]) * rng.uniform(0.03, 0.1)
    return out, Expected([("joint_slip", joint + 1)])


def _apart(rng: Generator, n: int, count: int) -> list[int]:
    while True:
        rows = np.sort(rng.integers(round(0.1 * n), round(0.9 * n), count))
        if count < 2 or np.diff(rows).min() > 0.12 * n:
            return [int(row) for row in rows]


def missed_single_joint(bench: Bench, q: Array, rng: Generator) -> tuple[Array, Expected]:
    """One servo's packet is lost now and then; the others move."""
    joint, out = _one(rng), q.copy()
    for row in np.sort(rng.choice(np.arange(2, len(q)), max(6, len(q) // 20), replace=False)):
        out[row, joint] = out[row - 1, joint]
    return out, Expected([("missed_command", None)])


def missed_various_joints(bench: Bench, q: Array, rng: Generator) -> tuple[Array, Expected]:
    """Packets are lost one by one, of any joint."""
    out = q.copy()
    for row in np.sort(rng.choice(np.arange(2, len(q)), max(8, len(q) // 15), replace=False)):
        joint = _one(rng)
        out[row, joint] = out[row - 1, joint]
    return out, Expected([("missed_command", None)])


def missed_runs(bench: Bench, q: Array, rng: Generator) -> tuple[Array, Expected]:
    """The controller hangs for several poses in a row."""
    out = q.copy()
    for start in _apart(rng, len(q), 3):
        out[start : start + int(rng.integers(3, 7))] = out[start - 1]
    return out, Expected([("missed_command", None)])


def potentiometer(bench: Bench, q: Array, rng: Generator) -> tuple[Array, Expected]:
    """The track's linearity: a smooth error of low order."""
    joint, out = _one(rng), q.copy()
    x = q[:, joint] / 0.8
    bow, tilt = rng.choice([-1, 1]) * rng.uniform(0.03, 0.08), rng.uniform(-0.06, 0.06)
    out[:, joint] += bow * x * x + tilt * x**3
    return out, Expected([("servo_nonlinearity", joint + 1)])


def gear_runout(bench: Bench, q: Array, rng: Generator) -> tuple[Array, Expected]:
    """A gear off its centre, with an overtone."""
    joint, out = _one(rng), q.copy()
    cycles, size, phase = rng.uniform(4.0, 12.0), rng.uniform(0.01, 0.03), rng.uniform(0, 6)
    angle = cycles * q[:, joint] + phase
    out[:, joint] += size * (np.sin(angle) + 0.15 * np.sin(2 * angle))
    return out, Expected([("servo_nonlinearity", joint + 1)])


def gain_and_curve(bench: Bench, q: Array, rng: Generator) -> tuple[Array, Expected]:
    """A track of another span that is bent, too."""
    joint, out = _one(rng), q.copy()
    x = q[:, joint]
    out[:, joint] = (1 + rng.choice([-1, 1]) * rng.uniform(0.05, 0.15)) * x + rng.choice([-1, 1]) * 0.15 * x * x
    return out, Expected([("servo_nonlinearity", joint + 1)], allowed=("servo_gain",))


def plain_gain(bench: Bench, q: Array, rng: Generator) -> tuple[Array, Expected]:
    """Microseconds a degree are not what was thought."""
    joint, out = _one(rng), q.copy()
    out[:, joint] *= 1 + rng.choice([-1, 1]) * rng.uniform(0.03, 0.15)
    return out, Expected([("servo_gain", joint + 1)])


def drift_two_constants(bench: Bench, q: Array, rng: Generator) -> tuple[Array, Expected]:
    """Winding and case warm at their own pace."""
    joint, out = _one(rng), q.copy()
    t = (bench.time_s - bench.time_s[0]) / bench.time_s[-1]
    sign = rng.choice([-1, 1])
    out[:, joint] += sign * (
        rng.uniform(0.02, 0.05) * (1 - np.exp(-t / 0.05)) + rng.uniform(0.03, 0.08) * (1 - np.exp(-t / 0.6))
    )
    return out, Expected([("thermal_drift", joint + 1)])


def drift_on_and_on(bench: Bench, q: Array, rng: Generator) -> tuple[Array, Expected]:
    """Creep of plastic: quick at first, never done."""
    joint, out = _one(rng), q.copy()
    t = (bench.time_s - bench.time_s[0]) / bench.time_s[-1]
    law = t if rng.random() < 0.5 else np.log1p(t / 0.03) / np.log1p(1 / 0.03)
    out[:, joint] += rng.choice([-1, 1]) * rng.uniform(0.04, 0.1) * law
    return out, Expected([("thermal_drift", joint + 1)])


def drift_temperature(bench: Bench, q: Array, rng: Generator) -> tuple[Array, Expected]:
    """A zero that follows the temperature, which was recorded, up and down."""
    joint, out = _one(rng), q.copy()
    out[:, joint] += rng.choice([-1, 1]) * rng.uniform(0.004, 0.01) * (bench.celsius - bench.celsius[0])
    return out, Expected([("thermal_drift", joint + 1)])


def dead_band_edge(bench: Bench, q: Array, rng: Generator) -> tuple[Array, Expected]:
    """The motor runs until the error is within the dead band and stops at its edge: the same motion as play."""
    joint, out = _one(rng), q.copy()
    half, at = rng.uniform(0.01, 0.04), q[0, joint]
    for row in range(len(q)):
        at = np.clip(at, q[row, joint] - half, q[row, joint] + half)
        out[row, joint] = at
    return out, Expected([("backlash", joint + 1)], allowed=("dead_band",))


def dead_band_plain(bench: Bench, q: Array, rng: Generator) -> tuple[Array, Expected]:
    """Below a threshold nothing moves; beyond it the servo goes all the way, to within a little."""
    joint, out = _one(rng), q.copy()
    band, at = rng.uniform(0.03, 0.09), q[0, joint]
    for row in range(len(q)):
        if abs(q[row, joint] - at) > band:
            at = q[row, joint] - np.sign(q[row, joint] - at) * 0.03 * band
        out[row, joint] = at
    return out, Expected([("dead_band", joint + 1)])


def play_soft(bench: Bench, q: Array, rng: Generator) -> tuple[Array, Expected]:
    """Play whose flanks yield: the last of the gap is taken up softly."""
    joint, out = _one(rng), q.copy()
    half, soft = rng.uniform(0.01, 0.035), rng.uniform(0.1, 0.4)
    at = q[0, joint] - half
    edge = (1 - soft) * half
    for row in range(len(q)):
        gap = q[row, joint] - at
        if abs(gap) > edge:  # pushed on by a flank that gives: the further in, the more of it
            push = abs(gap) - edge
            room = half - edge
            at += np.sign(gap) * (push - room * (1 - np.exp(-push / room)))
        out[row, joint] = at
    return out, Expected([("backlash", joint + 1)], allowed=("hysteresis",))


def spring_stiffening(bench: Bench, q: Array, rng: Generator) -> tuple[Array, Expected]:
    """Joints that give under gravity, the less the further."""
    torque = bench.torque_nm(q)
    give = rng.uniform(0.2, 0.5, 3)
    bend = give * torque
    return q + 0.06 * np.tanh(bend / 0.06), Expected([("gravity_sag", None)], allowed=("payload",))


def friction_lag(bench: Bench, q: Array, rng: Generator) -> tuple[Array, Expected]:
    """A lag that grows exponentially over the way after each reversal."""
    joint, out = _one(rng), q.copy()
    lag, way, held = rng.uniform(0.01, 0.04), rng.uniform(0.05, 0.2), 0.0
    for row, move in enumerate(_moves(q[:, joint])):
        held += (np.sign(move) * lag - held) * (1 - np.exp(-abs(move) / way))
        out[row, joint] -= held
    return out, Expected([("hysteresis", joint + 1)], allowed=("backlash",))


def nothing(bench: Bench, q: Array, rng: Generator) -> tuple[Array, Expected]:
    """A sound arm."""
    return q, Expected()


# In the order in which they act: electronics, servo, mechanics.
FORMS: dict[str, Fault] = {
    "nothing": nothing,
    "missed_single_joint": missed_single_joint,
    "missed_various_joints": missed_various_joints,
    "missed_runs": missed_runs,
    "whole_degrees_trimmed": whole_degrees_trimmed,
    "microseconds": microseconds,
    "truncated_counts": truncated_counts,
    "potentiometer": potentiometer,
    "gear_runout": gear_runout,
    "gain_and_curve": gain_and_curve,
    "plain_gain": plain_gain,
    "dead_band_edge": dead_band_edge,
    "dead_band_plain": dead_band_plain,
    "lag_constant_speed": lag_constant_speed,
    "lag_speed_and_tail": lag_speed_and_tail,
    "lag_share": lag_share,
    "play_soft": play_soft,
    "friction_lag": friction_lag,
    "slips_repeatedly": slips_repeatedly,
    "slips_and_back": slips_and_back,
    "drift_two_constants": drift_two_constants,
    "drift_on_and_on": drift_on_and_on,
    "drift_temperature": drift_temperature,
    "spring_stiffening": spring_stiffening,
}
