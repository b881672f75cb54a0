"""The grain of readings: protractors in whole degrees, encoders of few bits, pixels rounded before they were written.

A reading that lies on steps of s is off by up to s / 2 whatever the arm does, so no noise is less than s / sqrt(12),
and what only the steps of the reading explain is not the arm's.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from armtwin.calib.diagnosis.lattice import coarse_step
from armtwin.models.recordings.recording import Recording

Array = NDArray[np.float64]

# Marks of protractors and whole digits of written angles, in degrees; the first on which every reading lies counts.
_SCALES_DEG = (1.0, 0.5, 0.25, 0.2, 0.1)
# Pixels are rounded to whole ones or a simple part of them; finer steps are far below any detector's noise.
_ROUNDED_PX = (1.0, 0.5, 0.25, 0.2, 0.1)
# A written angle has six digits or more, a pixel four.
_SAME_RAD = 3e-6
_SAME_PX = 1e-4
# A count of 16 bits a turn; a reading is rounded exactly, so it is off its step by the digits it was written with.
_LEAST_STEP_RAD = 2.0 * np.pi / 65536
_OFF_SHARE = 1e-4
# Readings that are few may all lie on a scale by chance.
_LEAST_READINGS = 6
# Rounding to a step scatters readings by about the standard deviation of one; in few poses by half of it.
_PLAUSIBLE = 2.0
# Steps that are told from uneven readings are known to this part.
_SAME_STEP = 1e-3
# Part of its step within which a reading may lie uniformly.
_STD_OF_STEP = 1.0 / np.sqrt(12.0)


@dataclass(frozen=True)
class Grain:
    """The steps of a channel's readings: its name (`joint 2`, or all pixels), and the step in rad or px."""

    channel: str
    step: float

    @property
    def std(self) -> float:
        """Standard deviation of what rounding takes off, in the step's unit."""
        return self.step * float(_STD_OF_STEP)


def reading_grains(recording: Recording) -> list[Grain]:
    """Return the grain of a recording's readings, one for all pixels or one for each joint's angles that has one."""
    if any(np.isfinite(pixels).any() for pixels in recording.markers_px.values()):
        values = np.concatenate([pixels.ravel() for pixels in recording.markers_px.values()])
        step = _rounded(values[np.isfinite(values)], _ROUNDED_PX, _SAME_PX)
        return [Grain("pixels", step)] if step else []
    if recording.q_meas is None:
        return []
    grains = []
    for joint, (readings, commands) in enumerate(zip(recording.q_meas.T, recording.q_cmd.T, strict=True), start=1):
        seen = np.isfinite(readings)
        step = _step_of(readings[seen], commands[seen])
        if step:
            grains.append(Grain(f"joint {joint}", step))
    finest = min((grain.step for grain in grains), default=0.0)
    return [replace(grain, step=finest) if _is_multiple(grain.step, finest) else grain for grain in grains]


def _is_multiple(step: float, finest: float) -> bool:
    """Whether a step is several of another joint's: then commands are coarse, and this joint is read as finely."""
    times = step / finest
    return round(times) >= 2 and abs(times - round(times)) <= _SAME_STEP * times


def floor_of(grains: list[Grain]) -> float:
    """Return the least standard deviation that readings of these grains can have; 0 where none was found."""
    return max((grain.std for grain in grains), default=0.0)


def _step_of(readings: Array, commands: Array) -> float:
    """Return the step of angles, rad: one that they lie on unevenly, or a scale's on which all of them lie.

    Angles that were chosen, and whose commands were then sought, lie on steps too, far coarser than they scatter.
    """
    if len(readings) < _LEAST_READINGS:
        return 0.0
    step, _ = coarse_step(readings, _LEAST_STEP_RAD, _OFF_SHARE)
    scale = float(np.radians(_rounded(np.degrees(readings), _SCALES_DEG, float(np.degrees(_SAME_RAD)))))
    # Marks are counted from zero: readings that are all odd lie on whole degrees, not on steps of two.
    if step * _STD_OF_STEP > _PLAUSIBLE * _scatter(readings, commands):
        step = 0.0
    from_zero = np.abs(readings - np.round(readings / step) * step).max() <= _SAME_RAD if step else False
    return scale if scale and not from_zero else step


def _scatter(readings: Array, commands: Array) -> float:
    """Return how far readings lie off a smooth curve over their commands, rad."""
    degree = min(3, len(np.unique(commands)) - 1)
    curve = np.polynomial.Polynomial.fit(commands, readings, degree) if degree > 0 else np.mean
    return float(np.std(readings - curve(commands)))


def _rounded(values: Array, steps: tuple[float, ...], same: float) -> float:
    """Return the largest of some steps on which all values lie, counted from zero, or 0."""
    if len(values) < _LEAST_READINGS or np.ptp(values) == 0:
        return 0.0
    return next((step for step in steps if np.abs(values - np.round(values / step) * step).max() <= same), 0.0)
