"""The whole arm: joint by joint, then what single rows and all joints together say, and each joint again without it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from armtwin.calib.motion.events import gross_rows, missed_rows, without_commands
from armtwin.calib.motion.fit import Fit, fit, robust_cost, scale_of
from armtwin.calib.motion.joint_model import JointModel, noise_of
from armtwin.calib.motion.ladder import Climbed, climb
from armtwin.calib.motion.missed_runs import missed_runs
from armtwin.calib.motion.payload import Payload, as_payload
from armtwin.calib.motion.problem import MotionProblem, at_zeros, motion_problem
from armtwin.calib.motion.repeats import Repeats, repeats, without_stale
from armtwin.calib.motion.sampling import Late, late, refined
from armtwin.calib.motion.search import delayed, search_joint, weighed
from armtwin.calib.motion.series import Series, deviance_gain
from armtwin.models.motion.loop import INDEX, neutral

Array = NDArray[np.float64]
Rows = NDArray[np.intp]

# Delays of several joints that are this near to their mean are one delay of the whole arm, where the readings allow it.
_ONE_DELAY_S, _ONE_DELAY_SHARE = 0.002, 0.06
# What one shared number may cost of deviance at a joint, beyond its own.
_SHARED_COSTS = 10.0
# Rows that so many of the joints missed were missed by all.
_BY_ALL = 0.6
# Where so many of the joints that move rub plainly, friction is what the arm is followed by first.
_RUB = 0.6


@dataclass(frozen=True, eq=False)
class ArmModel:
    """What was found at the whole arm.

    Attributes:
        problem: with gross readings left out and missed commands left as they were heard.
        joints: each joint's model.
        late: from when on all answer later, or None.
        bus: from when on readings are repeated for several rows, or None.
        delay_s: the delay that all joints share, or None.
        payload: a mass at the tip, or None.
        gross, missed: rows by joint (from 0); `missed_by_all` says that they are the same rows.
        climbed: joints (from 0) that were followed by friction first.

    """

    problem: MotionProblem
    joints: tuple[JointModel, ...]
    late: Late | None = None
    bus: Repeats | None = None
    delay_s: float | None = None
    gross: Mapping[int, Rows] = field(default_factory=dict)
    missed: Mapping[int, Rows] = field(default_factory=dict)
    missed_by_all: bool = False
    payload: Payload | None = None
    climbed: Mapping[int, Climbed] = field(default_factory=dict)


def identify(problem: MotionProblem, tell: Callable[[str], None] = lambda _: None) -> ArmModel:
    """Find what is wrong with a moving arm, in bounded time."""
    n = problem.recording.n_joints
    bus = repeats(problem.recording)
    if bus is not None:
        problem = motion_problem(without_stale(problem.recording, bus))

    climbed: dict[int, Climbed] = {}

    def search(joint: int, base: Array | None, *, ties: bool = True) -> JointModel:
        tell(f"following joint {joint + 1} of {n} through its commands")
        begin = climbed[joint].model if joint in climbed else None
        return search_joint(problem, joint, base, lambda what: tell(f"found {what}"), ties=ties, begin=begin)

    tell("looking for a moment from which on all joints answer later")
    found = late(problem, [delayed(problem, joint) for joint in range(n) if problem.moves(joint)])
    found, climbed = _rubbing(problem, found, tell)
    for joint, one in climbed.items():
        problem = _with_series(problem, joint, one.series)
    base = found.put(neutral()) if climbed and found is not None else None
    models = [search(joint, base, ties=False) for joint in range(n)]
    if not climbed:
        problem = at_zeros(problem, np.array([m.fit.p[INDEX["zero_rad"]] for m in models]))
        moving = [m for m in models if problem.moves(m.joint)]
        found = found or late(problem, moving) or late(problem, moving, within=True)
        if found is not None:
            again = [search(joint, found.put(neutral()), ties=False) for joint in range(n)]
            found = refined(problem, [m for m in again if problem.moves(m.joint)], found) or found
            if _worth_it(problem, models, again):
                base = found.put(neutral())
            else:
                found = None
        if base is None and not problem.has_load:
            models = [weighed(problem, model) for model in models]
        else:
            models = [search(joint, base) for joint in range(n)]
    gross: dict[int, Rows] = {}
    missed: dict[int, Rows] = {}
    for joint in range(n):
        if joint in climbed:  # what these left of single rows is no more than a form that is not quite the arm's
            continue
        rows = np.union1d(
            missed_rows(problem.series[joint], models[joint]), missed_runs(problem.series[joint], models[joint])
        )
        if len(rows):
            heard = _heard_without(problem, joint, rows)
            problem, before = heard, problem
            again_one = search(joint, base)
            if _worth_it(problem, [models[joint]], [again_one]):
                missed[joint], models[joint] = rows, again_one
            else:
                problem = before
        rows = gross_rows(problem.series[joint], models[joint])
        if len(rows):
            gross[joint] = rows
            problem = _left_out(problem, joint, rows)
            models[joint] = search(joint, base)
    by_all = _missed_by_all(problem, missed)
    arm = _with_one_delay(ArmModel(problem, tuple(models), found, bus, None, gross, missed, by_all, None, climbed))
    # Where the load's shape was fitted, what a mass at the tip adds to the arm's own weight cannot be told from it.
    explained = None if climbed else as_payload(arm.problem, arm.joints)
    if explained is None:
        return arm
    problem, joints, payload = explained
    return replace(arm, problem=problem, joints=joints, payload=payload)


def _rubbing(
    problem: MotionProblem, found: Late | None, tell: Callable[[str], None]
) -> tuple[Late | None, dict[int, Climbed]]:
    """Follow all joints by friction; none are returned where most of them are explained otherwise."""
    moving = [joint for joint in range(problem.recording.n_joints) if problem.moves(joint)]

    def climbs(late_by: Late | None) -> dict[int, Climbed]:
        out = {}
        for number, joint in enumerate(moving, start=1):
            tell(f"asking how joint {joint + 1} rubs")
            one = climb(problem, joint, None if late_by is None else late_by.put(neutral()))
            if one is not None:
                out[joint] = one
            if len(out) + len(moving) - number < _RUB * len(moving):
                return {}
        return out

    return found, climbs(found)


def _left_out(problem: MotionProblem, joint: int, rows: Rows) -> MotionProblem:
    series = problem.series[joint]
    used = series.used.copy()
    used[rows] = False
    return _with_series(problem, joint, replace(series, used=used))


def _heard_without(problem: MotionProblem, joint: int, rows: Rows) -> MotionProblem:
    series = problem.series[joint]
    return _with_series(problem, joint, replace(series, sent=without_commands(series, rows)))


def _with_series(problem: MotionProblem, joint: int, series: Series) -> MotionProblem:
    changed = list(problem.series)
    changed[joint] = series
    return replace(problem, series=tuple(changed))


def _worth_it(problem: MotionProblem, before: list[JointModel], after: list[JointModel]) -> bool:
    """Whether the second models explain more, or as much with fewer causes."""
    gain = 0.0
    for old, new in zip(before, after, strict=True):
        gain += problem.series[new.joint].gain(old.fit.e, new.fit.e)
    fewer = sum(len(m.forms) for m in before) - sum(len(m.forms) for m in after)
    return gain > 50.0 - 20.0 * fewer


def _missed_by_all(problem: MotionProblem, missed: Mapping[int, Rows]) -> bool:
    moving = [j for j in range(problem.recording.n_joints) if problem.moves(j)]
    if len(moving) < 2 or len(missed) < max(2, _BY_ALL * len(moving)):
        return False
    sets = [set(rows.tolist()) for rows in missed.values()]
    shared = set.intersection(*sets)
    return len(shared) > _BY_ALL * min(len(one) for one in sets)


def _with_one_delay(arm: ArmModel) -> ArmModel:
    """Give all joints one delay where each of them agrees to it."""
    moving = [m for m in arm.joints if arm.problem.moves(m.joint)]
    delayed = [m for m in moving if "latency" in m.effects]
    if len(delayed) < 2 or len(delayed) < 0.6 * len(moving):
        return arm
    own = np.array([m.fit.p[INDEX["delay_s"]] for m in delayed])
    middle = float(np.median(own))
    if np.abs(own - middle).max() > max(_ONE_DELAY_S, _ONE_DELAY_SHARE * middle):
        return arm
    tried = np.unique([*own, *np.linspace(own.min(), own.max(), 9)])
    shared = min(tried.tolist(), key=lambda delay: sum(_at_delay(arm.problem, m, delay)[1] for m in moving))
    joints = list(arm.joints)
    for model in moving:
        series = arm.problem.series[model.joint]
        refit, _ = _at_delay(arm.problem, model, shared)
        loss = deviance_gain(refit.e[series.used], model.fit.e[series.used], model.noise_rad)
        if loss > _SHARED_COSTS + 0.01 * series.used.sum() and model not in delayed:
            return arm
        forms = tuple(form for form in model.forms if form.effect != "latency")
        ties = tuple(tie for tie in model.equivalents if tie[0] != "latency")
        joints[model.joint] = replace(
            model, forms=forms, fit=refit, noise_rad=noise_of(series, refit.e), equivalents=ties
        )
    return replace(arm, joints=tuple(joints), delay_s=shared)


def _at_delay(problem: MotionProblem, model: JointModel, delay_s: float) -> tuple[Fit, float]:
    """Fit a joint again with a given delay; return the fit, and its loss in units of the remainder before."""
    series = problem.series[model.joint]
    p = model.fit.p.copy()
    p[INDEX["delay_s"]] = delay_s
    kept = [slot for slot in model.slots if slot.slot != "delay_s"]
    found = fit(series, p, kept, model.noise_rad)
    scale = scale_of(series, model.fit.e, model.noise_rad)
    return found, robust_cost(found.e[series.used], scale) / scale**2
