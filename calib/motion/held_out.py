"""Motions that nothing was fitted to: what each model is off there, and what naming the causes gained.

Every model begins at the first measured angle of a motion and is never told a later one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from armtwin.calib.motion.identify import ArmModel
from armtwin.calib.motion.joint_model import JointModel, noise_of
from armtwin.calib.motion.problem import MotionProblem
from armtwin.calib.motion.refitting import without
from armtwin.calib.motion.series import memory_rows, rms
from armtwin.models.motion.loop import neutral

Array = NDArray[np.float64]

# A cause that makes the held-out error larger by this share, though it shows there, is not believed.
_WORSE = 1.05
# It shows there if it moves the angles by so much of the noise.
_SHOWS = 0.5
_DRAWS = 400
# Loads are those of the commands first, then of the angles that follow from them.
_LOOKS = 2


@dataclass(frozen=True, eq=False)
class HeldOut:
    """One joint (from 0) in one held-out motion; deviations over every sample of it, rad.

    `squares` (B, 2) are the sums of squares of blocks, before and after, that the gain's interval is drawn from.
    """

    trajectory: str
    joint: int
    command_rms_rad: float
    nominal_rms_rad: float
    before_rms_rad: float
    after_rms_rad: float
    after_worst_rad: float
    noise_floor_rad: float
    squares: Array


@dataclass(frozen=True)
class Gain:
    """What the causes take away of the held-out error of the geometric twin, percent, with its 95 % interval."""

    percent: float
    low: float
    high: float

    @classmethod
    def over(cls, motions: Sequence[HeldOut]) -> Gain:
        """Return the gain over motions, resampled in blocks that are longer than the remainder's memory."""
        if not motions:
            return cls(0.0, 0.0, 0.0)
        blocks = np.concatenate([motion.squares for motion in motions])
        if not blocks[:, 0].sum():
            return cls(0.0, 0.0, 0.0)
        rng = np.random.default_rng(0)
        drawn = blocks[rng.integers(0, len(blocks), (_DRAWS, len(blocks)))].sum(axis=1)
        gains = 100.0 * (1.0 - np.sqrt(drawn[:, 1] / np.maximum(drawn[:, 0], 1e-300)))
        total = blocks.sum(axis=0)
        percent = 100.0 * (1.0 - np.sqrt(total[1] / total[0]))
        return cls(float(percent), *(float(v) for v in np.quantile(gains, [0.025, 0.975])))


def held_out(arm: ArmModel, loud: Sequence[int]) -> tuple[HeldOut, ...]:
    """Follow every joint through every held-out motion; of `loud` joints nothing but the zero is believed."""
    problem = along_its_way(arm)
    out = []
    for motion in problem.held_motions:
        for model in arm.joints:
            out.append(_one(problem, model, motion, model.joint in loud))
    return tuple(out)


def along_its_way(arm: ArmModel) -> MotionProblem:
    """Return the problem with the loads, in what is held out, of angles that are predicted, not measured."""
    problem = arm.problem
    if not arm.climbed or not problem.held.any():
        return problem
    angles = problem.recording.q_cmd
    for _ in range(_LOOKS):
        series = list(problem.series)
        for joint, one in arm.climbed.items():
            if len(one.load_of_basis):
                load = np.where(problem.held, one.load_nm(problem, angles), series[joint].load_nm)
                series[joint] = replace(series[joint], load_nm=np.ascontiguousarray(load))
        problem = replace(problem, series=tuple(series))
        held = [replace(one, wanted=problem.held) for one in problem.series]
        angles = np.stack([one.predicted(m.fit.p) for one, m in zip(held, arm.joints, strict=True)], axis=-1)
    return problem


def _one(problem: MotionProblem, model: JointModel, motion: str, loud: bool) -> HeldOut:
    series = problem.whole(model.joint, motion)
    rows = series.used & problem.held
    best = model.geometric.p if loud else model.fit.p
    asked = replace(series, sent=np.ascontiguousarray(problem.recording.q_cmd[:, model.joint]))  # missed or not
    nominal, before = (asked.remainder(p)[rows] for p in (neutral(), model.geometric.p))
    after = series.remainder(best)[rows]
    length = max(10, 4 * memory_rows(after)) if len(after) > 20 else max(len(after), 1)
    number = np.arange(len(after)) // length
    squares = np.zeros((int(number[-1]) + 1 if len(number) else 1, 2))
    np.add.at(squares, number, np.stack([before**2, after**2], axis=1))
    return HeldOut(
        trajectory=motion,
        joint=model.joint,
        command_rms_rad=rms((series.sent - series.measured)[rows]),
        nominal_rms_rad=rms(nominal),
        before_rms_rad=rms(before),
        after_rms_rad=rms(after),
        after_worst_rad=float(np.abs(after).max()) if len(after) else 0.0,
        noise_floor_rad=model.noise_rad,
        squares=squares,
    )


def without_a_gain(arm: ArmModel) -> ArmModel:
    """Drop causes that the held-out motions speak against, though they would show there."""
    joints = list(arm.joints)
    problem = along_its_way(arm)
    for joint, model in enumerate(arm.joints):
        for effect in () if joint in arm.climbed else model.effects:  # those were asked motion by motion
            if len(joints[joint].effects) == 0:
                break
            less = without(arm.problem.series[joint], joints[joint], effect)
            now, then = _errors(problem, joints[joint]), _errors(problem, less)
            shows = rms(now - then) > _SHOWS * model.noise_rad
            if shows and _typical(now) > _WORSE * _typical(then) and rms(now) > rms(then):
                series = arm.problem.series[joint]
                joints[joint] = replace(less, noise_rad=noise_of(series, less.fit.e))
    return replace(arm, joints=tuple(joints))


def _errors(problem: MotionProblem, model: JointModel) -> Array:
    parts = []
    for motion in problem.held_motions:
        series = problem.whole(model.joint, motion)
        parts.append(series.remainder(model.fit.p)[series.used & problem.held])
    return np.concatenate(parts) if parts else np.zeros(1)


def _typical(e: Array) -> float:
    """Return the median of the absolute error: one flipped step does not dominate it."""
    return float(np.median(np.abs(e)))
