"""One servo in time: from the commands that it was sent to the angles that are read behind it.

    commands --missed, steps, dead band, gain, curve--> received --delay--> loop --play, zero--> angle

The loop follows the error e between the command and the shaft:

    inertia · dω/dt  =  e − droop·load − lag − time_constant·ω − friction(ω, load, e)·sign(ω),      |ω| ≤ speed limit

where all torques are divided by the loop's stiffness, so that they are angles of error: what the recording of angles
alone can tell. With time constant 0.020 s, limit 6.16 rad/s and nothing else it is the nominal servo. A step solves for
its mean speed, exactly without inertia and implicitly with it, and takes dry friction exactly: the shaft stands still
while the drive is within the friction (a proximal step). The lag is friction of bristles that bend before they slide
(P. Dahl, 1968): after a reversal it grows exponentially over the angle by which command and lag together travel.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]

# Every number that the loop knows, with the value at which it does nothing (or is the nominal servo's).
NEUTRAL: dict[str, float] = {
    # what the servo hears
    "delay_s": 0.0,
    "late_from_s": np.inf,  # from then until then every command is heard later by
    "late_until_s": np.inf,
    "late_s": 0.0,
    "gain": 1.0,
    "bend": 0.0,  # 1/rad: curvature of the angle over the command
    "twist": 0.0,  # 1/rad²: its third order
    "ripple_sin_rad": 0.0,  # an error periodic in the command
    "ripple_cos_rad": 0.0,
    "ripple_per_turn": 1.0,
    "step_rad": 0.0,
    "step_origin_rad": 0.0,
    "dead_band_rad": 0.0,
    # how it follows
    "time_constant_s": 0.020,
    "speed_rad_s": 6.16,
    "torque_nm": np.inf,
    "inertia_s2": 0.0,
    "coulomb_rad": 0.0,
    "load_share": 0.0,  # friction torque for each torque of load
    "drive_share": 0.0,  # and for each torque of the motor itself
    "stribeck_rad": 0.0,
    "stribeck_load_share": 0.0,
    "stribeck_drive_share": 0.0,
    "stribeck_speed_rad_s": 0.1,
    "droop_rad_nm": 0.0,
    "lag_rad": 0.0,  # friction that grows after a reversal, and the commanded angle over which it does
    "lag_angle_rad": 0.05,
    "stop_low_rad": -np.inf,
    "stop_high_rad": np.inf,
    # what is read behind it
    "zero_rad": 0.0,
    "play_rad": 0.0,
    "play_start": 0.0,  # where in its gap the link begins: -1 to 1
    "slip_rad": 0.0,
    "slip_s": np.inf,
    "drift_rad": 0.0,  # what the zero creeps, with this time constant
    "drift_s": 60.0,
    "creep_rad_s": 0.0,  # and for ever
}
SLOTS: tuple[str, ...] = tuple(NEUTRAL)
INDEX: dict[str, int] = {name: number for number, name in enumerate(SLOTS)}

# The nominal loop's time constant is five of these.
_STEP_S = 0.004
# A pause of seconds is passed in steps of its own length over this many: the arm rests long before.
_MOST_STEPS = 250
# Bristles that would let the shaft jump are given this share of their angle to travel.
_LEAST_TRAVEL = 0.1
# Times that are nearer than this are one.
_INSTANT_S = 1e-7

(
    _DELAY, _LATE_FROM, _LATE_UNTIL, _LATE, _GAIN, _BEND, _TWIST, _R_SIN, _R_COS, _R_TURN, _STEP, _ORIGIN, _DEAD,
    _TAU, _SPEED, _TORQUE, _INERTIA, _COULOMB, _LOAD, _DRIVE, _STRIBECK, _S_LOAD, _S_DRIVE, _S_SPEED, _DROOP,
    _LAG, _LAG_ANGLE, _LOW, _HIGH, _ZERO, _PLAY, _PLAY_START, _SLIP, _SLIP_S, _DRIFT, _DRIFT_S, _CREEP,
) = range(len(SLOTS))  # fmt: skip


def neutral() -> Array:
    """Return the nominal servo's values, one a slot."""
    return np.array(list(NEUTRAL.values()))


@njit(cache=True)
def received(q_cmd: Array, p: Array) -> Array:
    """(N,) commands as the servo takes them, rad, from those sent: steps, dead band, gain and curve."""
    out = np.empty_like(q_cmd)
    held = q_cmd[0]
    for row in range(len(q_cmd)):
        c = q_cmd[row]
        if p[_STEP] > 0.0:
            c = np.floor((c - p[_ORIGIN]) / p[_STEP] + 0.5) * p[_STEP] + p[_ORIGIN]
        if row == 0 or abs(c - held) > p[_DEAD]:
            held = c
        c = held
        bent = p[_GAIN] * c + p[_BEND] * c * c + p[_TWIST] * c * c * c
        turn = p[_R_TURN] * c
        out[row] = bent + p[_R_SIN] * np.sin(turn) + p[_R_COS] * np.cos(turn)
    return out


@njit(cache=True)
def follow(
    time_s: Array,
    given_s: Array,
    sent: Array,
    load_nm: Array,
    measured: Array,
    first: NDArray[np.bool_],
    wanted: NDArray[np.bool_],
    p: Array,
) -> Array:
    """(N,) angles, rad, that are read at `time_s` (N,) of a servo with values `p`, one a slot.

    `sent` (N,) are its commands, given at `given_s` (N,), usually its row's time after the row was read; `load_nm` (N,)
    is the torque that it has to hold. In rows `first` a motion begins, at the angle `measured` there; no other measured
    angle is looked at. Motions that are not `wanted` are passed over: what is returned of them is `measured`.
    """
    n = len(time_s)
    heard = received(sent, p)
    out = np.empty(n)
    x = y = w = lag = 0.0
    before_h = resistance = 0.0
    k = 0
    for row in range(n):
        if not wanted[row]:
            out[row] = measured[row]
            continue
        zero = p[_ZERO] + p[_CREEP] * (time_s[row] - time_s[0])
        if p[_DRIFT] != 0.0:
            zero += p[_DRIFT] * (1.0 - np.exp(-(time_s[row] - time_s[0]) / p[_DRIFT_S]))
        if time_s[row] >= p[_SLIP_S]:
            zero += p[_SLIP]
        if first[row]:
            y = measured[row] - zero
            x = y + 0.5 * p[_PLAY] * p[_PLAY_START]
            w = lag = 0.0
            if p[_LAG] > 0.0:  # an arm that rests short of its command is held there
                while k + 1 < n and given_s[k + 1] + p[_DELAY] <= time_s[row] - _INSTANT_S:
                    k += 1
                lag = min(max((heard[k] - p[_DROOP] * load_nm[row] - x) / p[_LAG], -1.0), 1.0)
            out[row] = measured[row]
            continue
        begin, end = time_s[row - 1], time_s[row]
        longest = max(_STEP_S, (end - begin) / _MOST_STEPS)
        now = begin
        while now < end - _INSTANT_S:
            late = p[_LATE_FROM] <= now + _INSTANT_S < p[_LATE_UNTIL]
            shift = p[_DELAY] + (p[_LATE] if late else 0.0)
            while k + 1 < n and given_s[k + 1] + shift <= now + _INSTANT_S:
                k += 1
            while k > 0 and given_s[k] + shift > now + _INSTANT_S:
                k -= 1
            # A step ends where the next command is heard, so that the angle is a smooth function of the delay.
            until = min(end, now + longest)
            if k + 1 < n:
                until = min(until, given_s[k + 1] + shift)
            if now + _INSTANT_S < p[_LATE_FROM] < until:
                until = p[_LATE_FROM]
            h = until - now
            command = heard[k]
            load = load_nm[row - 1] + (load_nm[row] - load_nm[row - 1]) * (0.5 * (now + until) - begin) / (end - begin)
            now = until
            sag = p[_DROOP] * load
            motor = command - x
            # Bristles make the loop stiffer by their slope, as long as they bend.
            towards = 1.0 if motor - sag > p[_LAG] * lag else -1.0
            bends = p[_LAG] * abs(towards - lag)
            stiff = 1.0 + bends / max(p[_LAG_ANGLE] - bends, _LEAST_TRAVEL * p[_LAG_ANGLE])
            # A first-order loop's way in a step is known exactly: the error falls by exp(-h / time constant).
            if h != before_h or p[_LAG] > 0.0:  # most steps are as long as the one before
                before_h, resistance = h, h * stiff / (1.0 - np.exp(-h * stiff / p[_TAU]))
            # Inertia that lasts over steps is integrated by the trapezoidal rule, what is gone within one implicitly.
            mass = p[_INERTIA] / h
            new = max(0.5, 1.0 - mass / resistance)
            drive = motor - sag - p[_LAG] * lag + (mass - resistance * (1.0 - new)) * w
            friction = p[_COULOMB] + p[_LOAD] * abs(sag) + p[_DRIVE] * abs(motor)
            rough = p[_STRIBECK] + p[_S_LOAD] * abs(sag) + p[_S_DRIVE] * abs(motor)
            if rough > 0.0:
                friction += rough * np.exp(-((w / p[_S_SPEED]) ** 2))
            drive = max(drive - friction, 0.0) if drive > 0.0 else min(drive + friction, 0.0)
            before = w
            w = drive / (mass + resistance * new)
            limit = p[_SPEED]
            if load * w > 0.0:
                limit *= max(0.0, 1.0 - abs(load) / p[_TORQUE])
            w = min(max(w, -limit), limit)
            shaft = x
            x += h * (new * w + (1.0 - new) * before) if mass > 0.0 else h * w
            if x > p[_HIGH]:
                x, w = p[_HIGH], min(w, 0.0)
            elif x < p[_LOW]:
                x, w = p[_LOW], max(w, 0.0)
            y = min(max(y, x - 0.5 * p[_PLAY]), x + 0.5 * p[_PLAY])
            if p[_LAG] > 0.0 and x != shaft:
                lag = _lagging(lag, x - shaft, p)
        out[row] = y + zero
    return out


@njit(cache=True)
def _lagging(lag: float, moved: float, p: Array) -> float:
    """Return the lag, -1 to 1, after the shaft moved by an angle: the command's travel is the shaft's and the lag's."""
    towards = 1.0 if moved > 0.0 else -1.0
    out = lag
    for _ in range(3):
        travel = abs(moved) + p[_LAG] * abs(out - lag)
        out = towards + (lag - towards) * np.exp(-travel / p[_LAG_ANGLE])
    return out
