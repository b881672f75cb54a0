"""What may be wrong with one joint: forms of effects with the values from which a fit begins."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armtwin.calib.motion.problem import MotionProblem
from armtwin.calib.motion.series import Series
from armtwin.models.catalogue.motion_effect import MotionEffect, Slot, motion_catalogue
from armtwin.models.motion.loop import INDEX, NEUTRAL

Array = NDArray[np.float64]

# Lattices that are looked for in the readings of an arm that rests: from a fraction of a degree to a bit of four.
_STEPS_RAD = np.geomspace(0.003, 0.35, 900)
_SHARP = 0.5
# The grain of the readings and its double are no lattice of the commands.
_BEYOND_GRAIN = 2.6
_SLOW_RAD_S = 0.05
# Of a joint that never turns back these are one with its zero, or with where it first stood.
_OF_REVERSALS = ("backlash", "hysteresis", "friction", "joint_slip")
# A load that varies by less tells nothing of what grows with it.
_LOADED_NM = 2e-3


@dataclass(frozen=True)
class Form:
    """One form of an effect at a joint; `ladder` is the number of the step beyond its first form, from 1, or 0."""

    effect: str
    slots: tuple[Slot, ...]
    ladder: int = 0


@dataclass(frozen=True)
class Start:
    """A form with the values at which its fit begins; None stands for a slot that is linear about nothing."""

    form: Form
    values: tuple[float | None, ...]


def forms_of(effect: MotionEffect) -> list[Form]:
    """List the first forms of an effect."""
    return [Form(effect.name, slots) for slots in effect.forms]


def starts(problem: MotionProblem, series: Series, p: Array, e: Array, active: Sequence[Form]) -> list[Start]:
    """List all that may be added to what a joint has already: other effects, and further steps of those it has."""
    taken = {slot.slot for form in active for slot in form.slots}
    names = {form.effect for form in active}
    turns_back = series.turns_back
    loaded = problem.has_load and bool(np.ptp(series.load_nm[series.used]) > _LOADED_NM)

    def may(slots: tuple[Slot, ...]) -> bool:
        of_load = any("load" in slot.slot for slot in slots)
        # What grows with the motor's own torque makes the loop slower, which a slower loop explains more simply.
        of_drive = any("drive" in slot.slot for slot in slots)
        free = not taken & {slot.slot for slot in slots}
        return free and (loaded or not of_load) and ("time_constant_s" in taken or not of_drive)

    out: list[Start] = []
    for effect in motion_catalogue().values():
        if (effect.needs_load and not loaded) or (effect.name in _OF_REVERSALS and not turns_back):
            continue
        if effect.name in names:
            for number, slots in enumerate(effect.further, start=1):
                if may(slots):
                    out += _starts_of(Form(effect.name, slots, number), series, p, e)
            continue
        for form in forms_of(effect):
            if may(form.slots):
                out += _starts_of(form, series, p, e)
    return out


def _starts_of(form: Form, series: Series, p: Array, e: Array) -> Iterable[Start]:
    name = form.slots[0].slot
    found = {
        "step_rad": lambda: _lattices(series, float(p[INDEX["zero_rad"]])),
        "slip_rad": lambda: _jumps(series, e),
        "torque_nm": lambda: _torques(series),
        "stop_high_rad": lambda: _stops(series, 1.0),
        "stop_low_rad": lambda: _stops(series, -1.0),
    }
    if name in found:
        return [Start(form, values) for values in found[name]()]
    choices = [[None if value == NEUTRAL[slot.slot] else value for value in slot.starts] for slot in form.slots]
    return [Start(form, values) for values in itertools.product(*choices)]


def _lattices(series: Series, zero_rad: float) -> list[tuple[float | None, ...]]:
    """Return steps and origins that the resting arm's readings are multiples of."""
    speed = np.abs(np.gradient(series.measured, series.time_s))
    rest = series.measured[(speed < _SLOW_RAD_S) & series.used]
    if len(rest) < 30 or np.ptp(rest) == 0.0:
        return []
    rest = rest[:: max(1, len(rest) // 4000)]
    least = max(_STEPS_RAD[0], _BEYOND_GRAIN * series.grain_rad)
    steps = _STEPS_RAD[(least < _STEPS_RAD) & (np.ptp(rest) / 2 > _STEPS_RAD)]
    if not len(steps):
        return []
    waves = np.array([np.exp(2j * np.pi * rest / step).mean() for step in steps])
    sharp = np.abs(waves)
    # Where every step fits (an arm that rests at two places), none is seen.
    peaks = [i for i in np.argsort(sharp)[::-1][:40] if sharp[i] > _SHARP]
    chosen: list[int] = []
    for i in peaks:
        if all(abs(np.log(steps[i] / steps[k])) > 0.03 for k in chosen):
            chosen.append(int(i))
    out: list[tuple[float | None, ...]] = []
    for i in chosen[:4]:
        fine = steps[i] * np.linspace(0.994, 1.006, 61)
        wave = np.array([np.exp(2j * np.pi * rest / step).mean() for step in fine])
        best = int(np.argmax(np.abs(wave)))
        out.append((float(fine[best]), float(np.angle(wave[best]) / (2 * np.pi) * fine[best]) - zero_rad))
    return out


def _jumps(series: Series, e: Array) -> list[tuple[float | None, ...]]:
    """Return the two moments at which the remainder's mean most plainly changes."""
    out: list[tuple[float | None, ...]] = []
    used = np.flatnonzero(series.used)
    capped = np.clip(e[used], *np.quantile(e[used], [0.01, 0.99]))
    n = len(capped)
    total = np.cumsum(capped)
    at = np.arange(1, n)
    between = (total[:-1] / at - (total[-1] - total[:-1]) / (n - at)) ** 2 * at * (n - at) / n
    edge = max(5, n // 100)
    between[:edge] = between[-edge:] = 0.0
    for _ in range(2):
        best = int(np.argmax(between))
        if between[best] > 0.0:
            out.append((None, float(series.time_s[used[best + 1]])))
        between[max(0, best - n // 20) : best + n // 20] = 0.0
    return out


def _torques(series: Series) -> list[tuple[float | None, ...]]:
    most = float(np.abs(series.load_nm).max())
    return [(share * most,) for share in (1.02, 1.3, 2.0, 4.0)] if most > 1e-6 else []


def _stops(series: Series, side: float) -> list[tuple[float | None, ...]]:
    """Return angles at which the readings crowd near their end while commands go further."""
    ahead = side * (series.sent - series.measured)
    far = (ahead > max(0.02, 4 * series.grain_rad)) & series.used
    if far.sum() < 5:
        return []
    ends = np.quantile(side * series.measured[far], [0.99, 0.9, 0.7])
    return [(float(side * end),) for end in np.unique(np.round(ends, 4))]
