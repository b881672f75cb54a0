"""The next experiment: where causes tie, the poses that separate them best."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from armtwin.calib.diagnosis.diagnosis import Diagnosis
from armtwin.calib.diagnosis.experiments.by_hand import hand_separation
from armtwin.calib.diagnosis.experiments.poses import CandidatePlan, candidates, in_small_steps, space_of
from armtwin.calib.diagnosis.experiments.rivals import Rivals, rivals_of
from armtwin.calib.diagnosis.experiments.separation import confirmed, extended, separations
from armtwin.calib.diagnosis.fit import Data
from armtwin.models.plan import Plan

# Rivals that are expected to be this many standard deviations apart will be told apart: a deviance of 25 is well above
# what makes a tie.
TELLING = 5.0
# Beyond this, farther apart is no better.
_ENOUGH = 30.0
_MOST_REPEATS = 4
# So many of the most promising plans are looked at by refitting, not only to first order.
_CONFIRMED = 3


# Separations by pair of rivals, for each group of them.
Found = list[dict[tuple[int, int], float]]


@dataclass(frozen=True, eq=False)
class Experiment:
    """Poses to be run next.

    Attributes:
        trajectory: the name of the plan's poses, new to the recording.
        plan: what to run, after the poses that were run already.
        tells_apart: effects that it separates.
        why: in words, for people.
        expected_separation: of the two of them that come nearest to each other, in standard deviations of the noise.
        instructions: what a person has to do besides; empty where the bench can run the plan alone.
        appends: whether its poses belong to the same recording; if not they are one of their own.

    """

    trajectory: str
    plan: Plan
    tells_apart: tuple[str, ...]
    why: str
    expected_separation: float
    instructions: tuple[str, ...]
    appends: bool


def propose(diagnosis: Diagnosis) -> Experiment | None:
    """Design the experiment that best tells apart what the diagnosis could not; None where there is nothing to tell.

    Plans stay inside the joint ranges of the recording with a small margin. What the bench can do alone comes first;
    where no such plan separates, the board, a gauge in the arm's plane or another place of the camera is asked for.
    """
    if diagnosis.only_held_out:  # the poses that tell are there: they have to be fitted, not run
        return None
    groups = rivals_of(diagnosis)
    if not groups:
        return None
    data = diagnosis.explanation.data
    space = space_of(data.problem.context)
    joints = _joints(groups, space.context.arm.n_joints)
    ranked = []
    for candidate in candidates(space, joints):
        at = extended(data, candidate, groups[0].models[0])
        ranked.append((_worth([separations(at, group) for group in groups]), candidate))
    ranked.sort(key=lambda row: -row[0])
    best: tuple[float, CandidatePlan, Found] | None = None
    for worth, candidate in ranked[:_CONFIRMED]:
        if best is not None and worth <= best[0]:
            break
        longer, found = _often_enough(data, candidate, groups)
        if best is None or _worth(found) > best[0]:
            best = (_worth(found), longer, found)
    if best is not None and _told(groups, best[2]):
        return _experiment(diagnosis, best[1], groups, best[2], appends=True)
    for candidate, by_hand in hand_separation(data, space, groups):
        if _told(groups, by_hand):
            return _experiment(diagnosis, candidate, groups, by_hand, appends=False)
    return None


def _often_enough(data: Data, candidate: CandidatePlan, groups: list[Rivals]) -> tuple[CandidatePlan, Found]:
    """Repeat a plan until it tells the rivals apart, if a few repetitions do; separations grow with their root."""

    def confirm(plan: CandidatePlan) -> Found:
        at = extended(data, plan, groups[0].models[0])
        return [confirmed(at, group) for group in groups]

    found = confirm(candidate)
    largest = max(separation for pairs in found for separation in pairs.values())
    if largest >= TELLING or largest * np.sqrt(_MOST_REPEATS) < TELLING:
        return candidate, found
    times = min(int(np.ceil((1.1 * TELLING / largest) ** 2)), _MOST_REPEATS)
    again = replace(
        candidate,
        q_cmd=np.tile(candidate.q_cmd, (times, 1)),
        payload_kg=np.tile(candidate.payload_kg, times),
        what=f"{candidate.what}, {times} times over",
    )
    longer = in_small_steps(again)
    return longer, confirm(longer)


def _joints(groups: list[Rivals], n: int) -> tuple[int, ...]:
    """Joints (from 0) that the rivals are about; all where they are about none."""
    named = {
        active.site.joint - 1
        for group in groups
        for active in group.effects
        if active is not None and active.site.joint is not None and active.effect.where == "joint"
    }
    return tuple(sorted(named)) or tuple(range(n))


def _worth(found: Found) -> float:
    """Sum over pairs of rivals of their separation, of which more than enough counts no more."""
    return float(sum(min(separation, _ENOUGH) + 1e-3 * separation for pairs in found for separation in pairs.values()))


def _told(groups: list[Rivals], found: Found) -> dict[str, float]:
    """Effects that are told from a rival, with the least separation of those pairs."""
    told: dict[str, float] = {}
    for group, pairs in zip(groups, found, strict=True):
        for pair, separation in pairs.items():
            if separation >= TELLING:
                for k in pair:
                    told[group.names[k]] = min(told.get(group.names[k], np.inf), separation)
    return told


def _experiment(
    diagnosis: Diagnosis,
    candidate: CandidatePlan,
    groups: list[Rivals],
    found: Found,
    *,
    appends: bool,
) -> Experiment:
    told = _told(groups, found)
    least = float(min(told.values()))
    names = tuple(name for name in told if name != "none")
    taken = {str(name) for name in diagnosis.problem.context.trajectory}
    trajectory, k = candidate.name, 2
    while trajectory in taken:
        trajectory, k = f"{candidate.name}_again_{k}", k + 1
    others = "nothing of the kind" if len(names) == 1 else "one another"
    why = (
        f"{candidate.what}; there {' and '.join(names)} differ from {others} by {least:.0f} standard deviations of the "
        "noise, after the geometry and all parameters were fitted again"
    )
    plan = Plan(np.full(len(candidate.q_cmd), trajectory), candidate.q_cmd, candidate.payload_kg)
    return Experiment(trajectory, plan, names, why, least, candidate.instructions, appends)
