"""The poses that make the weakest of the wanted faults findable, by exchange (V. Fedorov, 1972).

A sequence is bettered by moves that are kept if they help: another pose, a pose near the old one, one joint alone, a
stretch the other way round, a pose repeated. What is bettered is a soft minimum of what each fault is worth over what
it has to be worth to be found: no fault is given up for another, and there are more supports than one pair needs.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from armtwin.calib.arm.observability import Observability
from armtwin.models.plan import MAX_STEP_RAD, Plan, steps_between
from armtwin.scenarios.power.ground import Ground

Array = NDArray[np.float64]

MOVES = 5000
# How strongly the weakest counts: at 2 one that lacks half of what it needs weighs four times one that has it.
_SHARPNESS = 2.0
_NEARBY_RAD = 0.15
_TRIES = 30


@dataclass(frozen=True, eq=False)
class Design:
    """Poses that are proposed, held against the plan that they were asked for.

    Attributes:
        plan: the poses, in their order.
        ratios: by fault, what it is worth over what it needs to be found in 90 of 100 as on the old plan.
        at_half, at_twice: the same of faults half and twice as large, over what those are worth on the old plan.
        before, after: observability of the geometry by the old plan and by the new.
        path_before_mm, path_after_mm: error on the goal's path; None without one.

    """

    plan: Plan
    ratios: dict[str, float]
    at_half: dict[str, float]
    at_twice: dict[str, float]
    before: Observability
    after: Observability
    path_before_mm: float | None
    path_after_mm: float | None


def design(
    ground: Ground,
    old: Plan,
    n: int,
    ranges: Array,
    *,
    add: bool = False,
    moves: int = MOVES,
    seed: int = 0,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> Design:
    """Propose `n` poses in (joints, 2) ranges, or `n` more after those of the old plan."""
    rng = np.random.default_rng(seed)
    wanted = ground.wanted(ground.worth(old.q_cmd))
    fixed = len(old) if add else 0
    q = _start(ground, old, n, ranges, rng, add)
    best = _soft_minimum(ground.worth(q) / wanted)
    for number in range(moves):
        progress(number, moves)
        trial = _moved(q, fixed, ranges, rng)
        if not _can_be_run(trial, fixed) or not ground.is_seen(trial[fixed:]).all():
            continue
        value = _soft_minimum(ground.worth(trial) / wanted)
        if value > best:
            q, best = trial, value

    def ratios(times: float) -> dict[str, float]:
        worth = ground.worth(q, times) / np.maximum(ground.worth(old.q_cmd, times), 1e-9)
        named = zip(ground.faults, ground.fault_rows(), strict=True)
        return {fault.name: float(worth[row]) for fault, row in named}

    return Design(
        plan=Plan(np.full(len(q), "design"), q, np.zeros(len(q))),
        ratios=ratios(1.0),
        at_half=ratios(0.5),
        at_twice=ratios(2.0),
        before=ground.indices(old.q_cmd),
        after=ground.indices(q),
        path_before_mm=ground.path_error_mm(old.q_cmd),
        path_after_mm=ground.path_error_mm(q),
    )


def _soft_minimum(ratios: Array) -> float:
    """Return a mean of logarithms that the smallest ratios rule; what has more than enough hardly counts."""
    logs = np.minimum(np.log(np.maximum(ratios, 1e-9)), 3.0)
    lowest = float(logs.min())
    return lowest - float(np.log(np.mean(np.exp(-_SHARPNESS * (logs - lowest))))) / _SHARPNESS


def _start(ground: Ground, old: Plan, n: int, ranges: Array, rng: Generator, add: bool) -> Array:
    """Return a walk of seen poses in steps that the bench allows."""
    low, high = ranges.T
    q = old.q_cmd[-1:] if add else old.q_cmd[:1]
    walk: list[Array] = []
    while len(walk) < n:
        for _ in range(_TRIES):
            goal = rng.uniform(low, high)
            if ground.is_seen(goal[None]).all():
                break
        steps = steps_between(q[-1], goal, MAX_STEP_RAD)
        steps = steps[ground.is_seen(steps).all(axis=1)]
        if not len(steps) or np.abs(steps[0] - q[-1]).max() > MAX_STEP_RAD + 1e-9:
            continue
        walk += list(steps)
        q = np.concatenate([q, steps])
    new = np.array(walk[:n])
    return np.concatenate([old.q_cmd, new]) if add else new


def _moved(q: Array, fixed: int, ranges: Array, rng: Generator) -> Array:
    """Return the sequence after one random move of a pose that is not fixed."""
    out = q.copy()
    low, high = ranges.T
    k = int(rng.integers(fixed, len(q)))
    kind = rng.random()
    if kind < 0.3:
        out[k] = rng.uniform(low, high)
    elif kind < 0.6:
        out[k] = np.clip(q[k] + _NEARBY_RAD * rng.standard_normal(q.shape[1]), low, high)
    elif kind < 0.75:  # one joint alone moves from the pose before
        joint = int(rng.integers(q.shape[1]))
        out[k] = out[k - 1] if k > fixed else out[k]
        out[k, joint] = rng.uniform(low[joint], high[joint])
    elif kind < 0.9:  # a stretch the other way round: other sides of approach
        end = int(rng.integers(k, len(q))) + 1
        out[k:end] = q[k:end][::-1]
    else:  # a pose repeated, for what is pure error
        out[k] = q[int(rng.integers(fixed, len(q)))]
    return out


def _can_be_run(q: Array, fixed: int) -> bool:
    steps = np.abs(np.diff(q[max(fixed - 1, 0) :], axis=0))
    return bool(steps.size == 0 or steps.max() <= MAX_STEP_RAD + 1e-9)
