"""What a joint is sent through to tell causes apart in time: chirps, steps, slow reversals and holds."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

# A chirp goes from slow to about where a hobby servo no longer follows, no faster than its joint may turn.
_CHIRP_HZ, _CHIRP_S = (0.1, 3.0), 12.0
_CHIRP_SPEED_RAD_S = 2.0
# Steps of several sizes, as shares of the way from end to end, each out of rest.
_STEPS, _REST_S = (0.1, -0.1, 0.25, -0.25, 0.5, -0.5, 0.9, -0.9), 0.9
# No step is longer than a bench allows from pose to pose.
_LONGEST_STEP_RAD = 0.45
# Reversals creep, so that a servo stands and lets go.
_CREEP_RAD_S, _CREEP_SHARE, _TURNS = (0.12, 0.25), 0.35, 2
# Holds are approached from below and from above.
_HELD, _APPROACH_RAD_S, _HOLD_S = 5, 0.5, 1.0
# Between motions the joint goes back to its middle and rests.
BACK_RAD_S, PAUSE_S = 0.5, 1.0


def excitation(kind: str, low_rad: float, high_rad: float, rate_hz: float) -> Array:
    """(N,) angles, rad, of a motion within a range, one every 1/rate: it begins and ends at the range's middle."""
    middle, half = 0.5 * (low_rad + high_rad), 0.5 * (high_rad - low_rad)
    path = {"chirp": _chirp, "steps": _steps, "reversals": _reversals, "holds": _holds}[kind]
    angles = middle + np.clip(path(half, rate_hz), -half, half)
    return np.concatenate([angles, ramp(float(angles[-1]), middle, BACK_RAD_S, rate_hz), _rest(middle, rate_hz)])


def ramp(start_rad: float, end_rad: float, speed_rad_s: float, rate_hz: float) -> Array:
    """(N,) angles on a straight way, the end included and the start not."""
    n = max(1, int(np.ceil(abs(end_rad - start_rad) / speed_rad_s * rate_hz)))
    return start_rad + (end_rad - start_rad) * np.arange(1, n + 1) / n


def _rest(angle_rad: float, rate_hz: float) -> Array:
    return np.full(max(1, round(PAUSE_S * rate_hz)), angle_rad)


def _chirp(half: float, rate_hz: float) -> Array:
    t = np.arange(0.0, _CHIRP_S, 1.0 / rate_hz)
    top = min(_CHIRP_HZ[1], rate_hz / 8.0)
    growth = np.log(top / _CHIRP_HZ[0]) / _CHIRP_S
    phase = 2.0 * np.pi * _CHIRP_HZ[0] * np.expm1(growth * t) / growth
    speed = 2.0 * np.pi * _CHIRP_HZ[0] * np.exp(growth * t)
    return np.minimum(half, _CHIRP_SPEED_RAD_S / speed) * np.sin(phase)


def _steps(half: float, rate_hz: float) -> Array:
    rest = max(2, round(_REST_S * rate_hz))
    sizes = np.clip(2.0 * half * np.array(_STEPS), -_LONGEST_STEP_RAD, _LONGEST_STEP_RAD)
    levels = np.append(0.0, np.cumsum(sizes))
    levels -= 0.5 * (levels.max() + levels.min())
    return np.concatenate([ramp(0.0, float(levels[0]), BACK_RAD_S, rate_hz), np.repeat(levels, rest)])


def _reversals(half: float, rate_hz: float) -> Array:
    size, parts, at = _CREEP_SHARE * half, [], 0.0
    for speed in _CREEP_RAD_S:
        for end in (size, -size) * _TURNS:
            parts.append(ramp(at, end, speed, rate_hz))
            at = end
    return np.concatenate(parts)


def _holds(half: float, rate_hz: float) -> Array:
    hold, parts, at = max(2, round(_HOLD_S * rate_hz)), [], 0.0
    places = np.linspace(-half, half, _HELD)
    for end in (*places, *places[-2::-1]):
        parts += [ramp(at, float(end), _APPROACH_RAD_S, rate_hz), np.full(hold, end)]
        at = float(end)
    return np.concatenate(parts)
