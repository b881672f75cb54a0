"""The next experiment on a moving arm: motions, with times, that show what the ones that were recorded leave open."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armtwin.calib.motion.diagnosis import MotionDiagnosis
from armtwin.models.catalogue.motion_effect import MOTIONS, motion_effect_named
from armtwin.models.motion.excitation import PAUSE_S, excitation
from armtwin.models.plan import Plan

Array = NDArray[np.float64]

# Commands are given as often as they were, and no more often than serial servos take them.
_MOST_HZ = 50.0
# Only where the arm has been is it known to be free; a joint that was hardly moved gets this much, rad.
_LEAST_HALF_RAD, _MOST_HALF_RAD = 0.05, 0.6
_INSIDE = 0.9
_GO_RAD_S = 0.4
# What is held out may be left with so many times the noise; more is not yet understood.
NOT_FOLLOWED = 5.0


@dataclass(frozen=True, eq=False)
class NextMotion:
    """A plan with times, what it tells apart at which joints (from 1), and why."""

    plan: Plan
    joints: tuple[int, ...]
    tells_apart: tuple[str, ...]
    why: str

    @property
    def trajectory(self) -> str:
        """The names of its motions."""
        return ", ".join(dict.fromkeys(self.plan.trajectory.tolist()))


def propose_motion(found: MotionDiagnosis, number: int = 1) -> NextMotion | None:
    """Return the motions that break what ties, or show what is not understood; None where nothing is left to ask.

    `number` stands in the motions' names, so that they are names of their own in the recording that they are added to.
    """
    kinds, apart, reasons = _open(found)
    if not kinds:
        return None
    recording = found.recording
    rate = min(_MOST_HZ, 1.0 / float(np.median(np.diff(recording.time_s)[~recording.first[1:]])))
    ends = _ranges(recording.q_cmd)
    middle = ends.mean(axis=1)
    start = recording.q_cmd[-1]
    names: list[str] = []
    blocks: list[Array] = []
    n = max(1, int(np.ceil(np.abs(middle - start).max() / _GO_RAD_S * rate)))
    way = start + (middle - start) * np.arange(1, n + 1)[:, None] / n
    for joint in sorted(kinds):
        for kind in (one for one in MOTIONS if one in kinds[joint]):
            path = excitation(kind, float(ends[joint, 0]), float(ends[joint, 1]), rate)
            q = np.tile(middle, (len(path), 1))
            q[:, joint] = path
            if not blocks:  # from where the arm was left
                q = np.concatenate([way, np.tile(middle, (round(PAUSE_S * rate), 1)), q])
            blocks.append(q)
            names += [f"{kind}_{joint + 1}_round_{number}"] * len(q)
    q_cmd = np.concatenate(blocks)
    plan = Plan(np.array(names), q_cmd, np.zeros(len(q_cmd)), np.arange(len(q_cmd)) / rate)
    return NextMotion(
        plan, tuple(joint + 1 for joint in sorted(kinds)), tuple(dict.fromkeys(apart)), "; ".join(reasons)
    )


def _open(found: MotionDiagnosis) -> tuple[dict[int, set[str]], list[str], list[str]]:
    """Return by joint (from 0) which motions would tell more, the effects that they tell apart, and why."""
    kinds: dict[int, set[str]] = {}
    apart: list[str] = []
    reasons: list[str] = []
    moving = [joint for joint in range(found.recording.n_joints) if found.problem.moves(joint)]
    for cause in found.causes:
        if not cause.equivalents:
            continue
        tied = (cause.effect, *cause.equivalents)
        for joint in moving if cause.joint is None else [cause.joint - 1]:
            kinds.setdefault(joint, set()).update(kind for name in tied for kind in motion_effect_named(name).motions)
        apart += tied
        whose = "the arm" if cause.joint is None else f"joint {cause.joint}"
        reasons.append(f"{' and '.join(tied)} at {whose} show alike in these motions")
    for joint in found.loud:
        kinds.setdefault(joint, set()).update(MOTIONS)
        reasons.append(f"what joint {joint + 1} does is explained by nothing")
    changing = {one.joint for one in found.by_motion if one.differs}
    missed = {one.joint for one in found.held_out if one.after_rms_rad > NOT_FOLLOWED * one.noise_floor_rad}
    for joint in sorted((changing | missed) - set(found.loud)):
        kinds.setdefault(joint, set()).update(("chirp", "steps", "reversals"))
        why = (
            "has other numbers from motion to motion" if joint in changing else "is not followed where it was held out"
        )
        reasons.append(f"joint {joint + 1} {why}")
    return kinds, apart, reasons


def _ranges(q_cmd: Array) -> Array:
    """(n, 2) angles between which each joint may be sent: inside those where it was."""
    low, high = q_cmd.min(axis=0), q_cmd.max(axis=0)
    middle, half = 0.5 * (low + high), np.clip(_INSIDE * 0.5 * (high - low), _LEAST_HALF_RAD, _MOST_HALF_RAD)
    return np.stack([middle - half, middle + half], axis=1)
