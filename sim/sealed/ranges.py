"""From which ranges the hidden effects of sealed worlds are drawn.

Each effect has one amplitude, which is scaled until the markers move as far as the wanted strength says; all else
(signs, directions, joints, times) is drawn here.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from armtwin.models.arm import Arm

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Situation:
    """What an effect is drawn for: the arm, the number of poses, the recording's span, the markers looked for.

    `steps_px` (N,) is how far the markers move from one pose to the next, and `target_px` how far the effect is to
    move them, pixels.
    """

    arm: Arm
    n_poses: int
    span_s: float
    markers: tuple[str, ...]
    steps_px: Array
    target_px: float


@dataclass(frozen=True, eq=False)
class Hidden:
    """An effect at a place: `parameters` of an amplitude, to be scaled from `start` up to at most `most`.

    Where `most` is `start` the amplitude is not scaled: the effect moves the markers as far as it does.
    """

    parameters: Callable[[float], dict[str, Any]]
    start: float
    most: float
    joint: int | None = None
    marker: str | None = None


def draw_hidden(effect: str, rng: Generator, situation: Situation) -> Hidden:
    """Draw where and how `effect` is hidden; raises `KeyError` for a name that is not in `EFFECTS`."""
    return _DRAWS[effect](rng, situation)


def _sign(rng: Generator) -> float:
    return 1.0 if rng.random() < 0.5 else -1.0


def _joint(rng: Generator, situation: Situation) -> int:
    return int(rng.integers(1, situation.arm.n_joints + 1))


def _event(rng: Generator, situation: Situation) -> int:
    return int(rng.integers(round(0.25 * situation.n_poses), round(0.75 * situation.n_poses)))


def _direction(rng: Generator, dimensions: int) -> Array:
    v = rng.standard_normal(dimensions)
    return np.asarray(v / np.linalg.norm(v))


def _backlash(rng: Generator, s: Situation) -> Hidden:
    return Hidden(lambda a: {"width_rad": a}, 0.01, 0.15, _joint(rng, s))


def _hysteresis(rng: Generator, s: Situation) -> Hidden:
    ratio = rng.uniform(3.0, 8.0)  # build-up in lags; below about 2.5 the link would have to jump
    return Hidden(lambda a: {"lag_rad": a, "length_rad": ratio * a}, 0.005, 0.06, _joint(rng, s))


def _dead_band(rng: Generator, s: Situation) -> Hidden:
    return Hidden(lambda a: {"threshold_rad": a}, 0.02, 0.15, _joint(rng, s))


def _quantization(rng: Generator, s: Situation) -> Hidden:
    """Draw one step for all servos, or one each; counted from each joint's zero or from where it was trimmed."""
    n = s.arm.n_joints
    scales = rng.uniform(0.8, 1.25, n) if rng.random() < 0.4 else np.ones(n)
    trims = rng.uniform(-0.5, 0.5, n) if rng.random() < 0.7 else np.zeros(n)  # in steps

    def parameters(a: float) -> dict[str, Any]:
        steps = {f"step{j + 1}_rad": float(a * scales[j]) for j in range(n)}
        return steps | {f"origin{j + 1}_rad": float(a * scales[j] * trims[j]) for j in range(n)}

    return Hidden(parameters, 0.0175, 0.12)


def _gravity_sag(rng: Generator, s: Situation) -> Hidden:
    shares = rng.uniform(0.3, 1.0, s.arm.n_joints)
    return Hidden(lambda a: {f"compliance{j + 1}_rad_per_nm": a * v for j, v in enumerate(shares)}, 0.05, 1.0)


def _link_bending(rng: Generator, s: Situation) -> Hidden:
    # The last link carries only the tip and stands on no other, so its bending is hardly ever seen.
    link = int(rng.integers(1, max(2, s.arm.n_joints)))
    # A printed bar of 12 x 15 mm has about 0.1 per N m2, one of 4 x 10 mm eight times ten of it.
    return Hidden(lambda a: {"flexibility_per_nm2": a}, 1.0, 8.0, link)


def _payload(rng: Generator, s: Situation) -> Hidden:
    shares = rng.uniform(0.3, 1.0, s.arm.n_joints)
    mass = float(rng.uniform(0.05, 0.25))
    start = 0 if rng.random() < 0.3 else _event(rng, s)

    def parameters(a: float) -> dict[str, Any]:
        springs = {f"compliance{j + 1}_rad_per_nm": a * v for j, v in enumerate(shares)}
        return {"mass_kg": mass, "from_sample": start, **springs}

    return Hidden(parameters, 0.05, 0.6)


def _servo_gain(rng: Generator, s: Situation) -> Hidden:
    sign = _sign(rng)
    return Hidden(lambda a: {"gain": 1.0 + sign * a}, 0.03, 0.3, _joint(rng, s))


def _servo_nonlinearity(rng: Generator, s: Situation) -> Hidden:
    cycles, phase = float(rng.uniform(2.0, 12.0)), float(rng.uniform(-np.pi, np.pi))

    def parameters(a: float) -> dict[str, Any]:
        return {"amplitude_rad": a, "cycles_per_turn": cycles, "phase_rad": phase}

    # A gear bored off by more than a fifth of its radius would not mesh.
    return Hidden(parameters, 0.005, 0.2 / cycles, _joint(rng, s))


def _thermal_drift(rng: Generator, s: Situation) -> Hidden:
    sign, constant = _sign(rng), float(rng.uniform(0.08, 0.5)) * s.span_s
    return Hidden(lambda a: {"drift_rad": sign * a, "time_constant_s": constant}, 0.01, 0.2, _joint(rng, s))


def _joint_slip(rng: Generator, s: Situation) -> Hidden:
    """Draw a slip, and sometimes others after it, or the way back."""
    start = _event(rng, s)
    shares, rows = [_sign(rng)], [start]
    form = rng.random()
    if form > 0.5:  # again, from one sample in twelve on
        apart = max(3, round(s.n_poses / 12))
        rows.append(min(start + int(rng.integers(apart, 3 * apart)), round(0.9 * s.n_poses)))
        shares.append(-shares[0] if form > 0.75 else _sign(rng) * float(rng.uniform(0.6, 1.2)))
    names = [(f"jump{k or ''}_rad", f"from_sample{k or ''}") for k in (0, 2)]

    def parameters(a: float) -> dict[str, Any]:
        slips = zip(names, shares, rows, strict=False)
        return {key: value for (jump, row), share, at in slips for key, value in ((jump, share * a), (row, at))}

    return Hidden(parameters, 0.01, 0.3, _joint(rng, s))


def _settling_lag(rng: Generator, s: Situation) -> Hidden:
    """Draw shares of each step that are left, or a speed with which long moves do not arrive."""
    shares = rng.uniform(0.5, 1.0, s.arm.n_joints)
    if rng.random() < 0.6:
        return Hidden(lambda a: {f"remaining{j + 1}": a * v for j, v in enumerate(shares)}, 0.1, 0.6)
    tail = float(rng.uniform(0.0, 0.2))
    # The slower, the farther off: the amplitude is the part of a stroke of 0.3 rad that a servo does not get through.
    slow = {f"remaining{j + 1}": tail * float(v) for j, v in enumerate(shares)}
    return Hidden(lambda a: {**slow, "reach_rad": 0.3 * (1.0 - a)}, 0.3, 0.9)


def _missed_command(rng: Generator, s: Situation) -> Hidden:
    """Draw commands that are lost: of all joints, or of a single one; apart from one another, or several in a row."""
    # Of the commands that would have moved the markers about as far as wanted, some are lost.
    count = int(rng.integers(3, max(4, round(0.04 * s.n_poses)) + 1))
    far = np.abs(np.log(np.maximum(s.steps_px[1:], 1e-9) / s.target_px))
    run = int(rng.integers(2, 4)) if rng.random() < 0.25 else 1
    taken: list[int] = []
    for row in rng.permutation(1 + np.argsort(far)[: 6 * count]):
        if len(taken) < count and all(abs(row - other) > run for other in taken):
            taken.append(int(row))
    rows = sorted({row + k for row in taken for k in range(run) if row + k < s.n_poses})
    key = f"samples{int(rng.integers(1, s.arm.n_joints + 1))}" if rng.random() < 0.4 else "samples"
    return Hidden(lambda a: {key: rows}, 1.0, 1.0)


def _command_shift(rng: Generator, s: Situation) -> Hidden:
    rows = int(_sign(rng) * rng.integers(1, 4))
    return Hidden(lambda a: {"rows": rows}, 1.0, 1.0)


def _plane_offset(rng: Generator, s: Situation) -> Hidden:
    sign = _sign(rng)
    return Hidden(lambda a: {"offset_mm": sign * a}, 5.0, 40.0)


def _camera_tilt(rng: Generator, s: Situation) -> Hidden:
    x, y = _direction(rng, 2)
    return Hidden(lambda a: {"tilt_x_rad": a * x, "tilt_y_rad": a * y}, 0.02, 0.05)


def _moving_camera(rng: Generator) -> Callable[[float], dict[str, Any]]:
    turn, shift = _direction(rng, 3), 0.3 * 485.0 * _direction(rng, 3)  # mm per rad: half a turn about the arm's plane

    def parameters(a: float) -> dict[str, Any]:
        rotations = {f"rotation_{axis}_rad": a * v for axis, v in zip("xyz", turn, strict=True)}
        return rotations | {f"translation_{axis}_mm": a * v for axis, v in zip("xyz", shift, strict=True)}

    return parameters


def _camera_moved(rng: Generator, s: Situation) -> Hidden:
    move, start = _moving_camera(rng), _event(rng, s)
    return Hidden(lambda a: {**move(a), "from_sample": start}, 0.002, 0.04)


def _camera_drift(rng: Generator, s: Situation) -> Hidden:
    return Hidden(_moving_camera(rng), 0.002, 0.04)


def _focal_length(rng: Generator, s: Situation) -> Hidden:
    sign, start = _sign(rng), _event(rng, s)  # off from the start it is a scale of the whole arm
    return Hidden(lambda a: {"scale": 1.0 + sign * a, "from_sample": start}, 0.005, 0.15)


def _lens_distortion(rng: Generator, s: Situation) -> Hidden:
    sign, p = _sign(rng), 0.02 * _direction(rng, 2)
    return Hidden(lambda a: {"k1": sign * a, "p1": a * p[0], "p2": a * p[1]}, 0.05, 0.5)


def _marker_offset(rng: Generator, s: Situation) -> Hidden:
    name = str(rng.choice([m for m in s.markers if m in s.arm.marker_names[:-1]]))
    x, y = _direction(rng, 2)
    body = int(rng.integers(0, 2))
    return Hidden(lambda a: {"x_mm": a * x, "y_mm": a * y, "body": body}, 1.0, 15.0, marker=name)


def _marker_swap(rng: Generator, s: Situation) -> Hidden:
    k = int(rng.integers(1, len(s.markers)))
    count = int(rng.integers(3, max(4, round(0.06 * s.n_poses)) + 1))
    samples = sorted(int(row) for row in rng.choice(s.n_poses, size=count, replace=False))
    return Hidden(lambda a: {"samples": samples, "other": s.markers[k]}, 1.0, 1.0, marker=s.markers[k - 1])


def _outliers(rng: Generator, s: Situation) -> Hidden:
    rate = float(rng.uniform(0.01, 0.05))
    return Hidden(lambda a: {"rate": rate, "size_px": a}, 10.0, 80.0)


def _axis_tilt(rng: Generator, s: Situation) -> Hidden:
    x, y = _direction(rng, 2)
    square = int(rng.integers(0, 2))

    def parameters(a: float) -> dict[str, Any]:
        return {"tilt_x_rad": a * x, "tilt_y_rad": a * y, "square_at_zero": square}

    return Hidden(parameters, 0.02, 0.2, _joint(rng, s))


_DRAWS: Mapping[str, Callable[[Generator, Situation], Hidden]] = {
    "backlash": _backlash,
    "hysteresis": _hysteresis,
    "dead_band": _dead_band,
    "quantization": _quantization,
    "gravity_sag": _gravity_sag,
    "link_bending": _link_bending,
    "payload": _payload,
    "servo_gain": _servo_gain,
    "servo_nonlinearity": _servo_nonlinearity,
    "thermal_drift": _thermal_drift,
    "joint_slip": _joint_slip,
    "settling_lag": _settling_lag,
    "missed_command": _missed_command,
    "command_shift": _command_shift,
    "plane_offset": _plane_offset,
    "camera_tilt": _camera_tilt,
    "camera_moved": _camera_moved,
    "camera_drift": _camera_drift,
    "focal_length": _focal_length,
    "lens_distortion": _lens_distortion,
    "marker_offset": _marker_offset,
    "marker_swap": _marker_swap,
    "outliers": _outliers,
    "axis_tilt": _axis_tilt,
}
EFFECTS: tuple[str, ...] = tuple(_DRAWS)
# Effects that the geometry absorbs altogether, so that they are scaled by how far they move the markers at all.
GAUGE = frozenset({"plane_offset"})
# Effects that need gravity in the arm's plane, and those that need two markers or more to show.
NEEDS_GRAVITY = frozenset({"gravity_sag", "link_bending", "payload"})
NEEDS_MARKERS = frozenset({"marker_offset", "marker_swap"})
NEEDS_TIME = frozenset({"thermal_drift"})
