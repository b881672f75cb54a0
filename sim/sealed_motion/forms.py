"""How each effect of a moving arm is hidden in a sealed log: which forms and sizes of it are drawn."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Situation:
    """What an effect is drawn for.

    Attributes:
        time_s: (N,) times of the rows.
        q_cmd: (N, n) commands, rad.
        loads_nm: (n,) largest torque of gravity at each joint.
        stiffness_nm_rad: of the nominal loop.

    """

    time_s: Array
    q_cmd: Array
    loads_nm: Array
    stiffness_nm_rad: float

    @property
    def span_s(self) -> float:
        """Time from the first row to the last."""
        return float(self.time_s[-1] - self.time_s[0])

    def moment(self, rng: Generator) -> float:
        """Draw a moment of the middle half, halfway between two rows."""
        row = int(rng.integers(len(self.time_s) // 4, 3 * len(self.time_s) // 4))
        return float(0.5 * (self.time_s[row] + self.time_s[row + 1]))


# Parameters of an effect of `size` times its usual size at a joint (index from 0).
Form = Callable[[Generator, Situation, int, float], dict[str, Any]]


def _log(rng: Generator, low: float, high: float) -> float:
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def _sign(rng: Generator) -> float:
    return 1.0 if rng.random() < 0.5 else -1.0


def _latency(rng: Generator, s: Situation, joint: int, size: float) -> dict[str, Any]:
    return {"delay_s": min(size * _log(rng, 0.01, 0.1), 0.4)}


def _lag(rng: Generator, s: Situation, joint: int, size: float) -> dict[str, Any]:
    return {"time_constant_s": 0.020 + size * _log(rng, 0.008, 0.1)}


def _speed(rng: Generator, s: Situation, joint: int, size: float) -> dict[str, Any]:
    return {"speed_rad_s": _log(rng, 0.4, 2.5) / size}


def _torque(rng: Generator, s: Situation, joint: int, size: float) -> dict[str, Any]:
    return {"torque_nm": float(s.loads_nm[joint]) * (1.0 + rng.uniform(0.3, 1.5) / size)}


def _friction(rng: Generator, s: Situation, joint: int, size: float) -> dict[str, Any]:
    coulomb = size * _log(rng, 0.004, 0.03)
    out = {"coulomb_rad": coulomb}
    form = rng.integers(3)
    if form == 1:
        out |= {"stribeck_rad": coulomb * rng.uniform(0.5, 1.5), "stribeck_speed_rad_s": _log(rng, 0.05, 0.3)}
    if form == 2 and s.loads_nm[joint] > 0.05:
        per_load = coulomb * s.stiffness_nm_rad / float(s.loads_nm[joint])
        out |= {"load_share": min(per_load * rng.uniform(0.3, 1.0), 0.9)}
    return {name: float(value) for name, value in out.items()}


def _inertia(rng: Generator, s: Situation, joint: int, size: float) -> dict[str, Any]:
    return {"armature_kg_m2": size * s.stiffness_nm_rad * _log(rng, 2e-4, 2e-3)}


def _sampling(rng: Generator, s: Situation, joint: int, size: float) -> dict[str, Any]:
    period = float(np.median(np.diff(s.time_s)))
    from_s = s.moment(rng)
    if rng.random() < 0.6:
        return {"from_s": from_s, "delay_s": size * _log(rng, 0.02, 0.12)}
    rows = int(np.clip(round(size * rng.uniform(0.05, 0.12) / period), 2, 50))
    return {"from_s": from_s, "held_rows": rows, "of_commands": int(rng.random() < 0.5)}


def _contact(rng: Generator, s: Situation, joint: int, size: float) -> dict[str, Any]:
    share = min(0.3, size * rng.uniform(0.06, 0.2))
    side = _sign(rng)
    stop = np.quantile(s.q_cmd[:, joint], 1.0 - share if side > 0 else share)
    return {"stop_rad": float(stop), "side": side}


def _backlash(rng: Generator, s: Situation, joint: int, size: float) -> dict[str, Any]:
    return {"width_rad": size * _log(rng, 0.008, 0.05)}


def _hysteresis(rng: Generator, s: Situation, joint: int, size: float) -> dict[str, Any]:
    lag = size * _log(rng, 0.004, 0.025)
    return {"lag_rad": lag, "length_rad": lag * rng.uniform(3.0, 8.0)}


def _dead_band(rng: Generator, s: Situation, joint: int, size: float) -> dict[str, Any]:
    return {"threshold_rad": size * _log(rng, 0.012, 0.06)}


def _quantization(rng: Generator, s: Situation, joint: int, size: float) -> dict[str, Any]:
    step = size * _log(rng, 0.015, 0.08)
    return {"step_rad": step, "origin_rad": step * rng.uniform(-0.5, 0.5)}


def _sag(rng: Generator, s: Situation, joint: int, size: float) -> dict[str, Any]:
    return {"compliance_rad_per_nm": size * _log(rng, 0.03, 0.2)}


def _payload(rng: Generator, s: Situation, joint: int, size: float) -> dict[str, Any]:
    return {"mass_kg": min(size * _log(rng, 0.05, 0.3), 2.0)}


def _gain(rng: Generator, s: Situation, joint: int, size: float) -> dict[str, Any]:
    return {"gain": 1.0 + _sign(rng) * min(size * _log(rng, 0.02, 0.1), 0.4)}


def _nonlinearity(rng: Generator, s: Situation, joint: int, size: float) -> dict[str, Any]:
    if rng.random() < 0.5:
        return {"curvature_per_rad": _sign(rng) * min(size * _log(rng, 0.05, 0.2), 0.3)}
    cycles, phase = rng.uniform(3.0, 12.0), rng.uniform(-np.pi, np.pi)
    amplitude = min(size * _log(rng, 0.004, 0.02), 0.5 / cycles)
    return {
        "sine_rad": float(amplitude * np.cos(phase)),
        "cosine_rad": float(amplitude * np.sin(phase)),
        "cycles_per_turn": float(cycles),
    }


def _drift(rng: Generator, s: Situation, joint: int, size: float) -> dict[str, Any]:
    drift = _sign(rng) * min(size * _log(rng, 0.01, 0.06), 0.4)
    return {"drift_rad": drift, "time_constant_s": float(s.span_s * rng.uniform(0.12, 0.5))}


def _slip(rng: Generator, s: Situation, joint: int, size: float) -> dict[str, Any]:
    return {"jump_rad": _sign(rng) * min(size * _log(rng, 0.012, 0.1), 0.6), "from_s": s.moment(rng)}


def _missed(rng: Generator, s: Situation, joint: int, size: float) -> dict[str, Any]:
    period, rows = float(np.median(np.diff(s.time_s))), len(s.time_s)
    lost: set[int] = set()
    for _ in range(int(rng.integers(6, 14))):
        first = int(rng.integers(1, rows - 1))
        lost |= set(range(first, min(rows, first + max(2, round(size * rng.uniform(0.15, 0.5) / period)))))
    return {"samples": sorted(lost)}


def _outliers(rng: Generator, s: Situation, joint: int, size: float) -> dict[str, Any]:
    return {"rate": float(rng.uniform(0.006, 0.03)), "size_rad": min(size * _log(rng, 0.08, 0.6), 1.5)}


FORMS: dict[str, Form] = {
    "latency": _latency,
    "servo_lag": _lag,
    "speed_limit": _speed,
    "torque_limit": _torque,
    "friction": _friction,
    "inertia": _inertia,
    "sampling": _sampling,
    "contact": _contact,
    "backlash": _backlash,
    "hysteresis": _hysteresis,
    "dead_band": _dead_band,
    "quantization": _quantization,
    "gravity_sag": _sag,
    "payload": _payload,
    "servo_gain": _gain,
    "servo_nonlinearity": _nonlinearity,
    "thermal_drift": _drift,
    "joint_slip": _slip,
    "missed_command": _missed,
    "outliers": _outliers,
}
# These show only where gravity loads their joint.
OF_LOAD = ("torque_limit", "gravity_sag", "payload")
