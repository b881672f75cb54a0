"""The diagnosis' rule, played on draws of the noise: how often a fault of a size is found, and as what.

The rule is that of calib/diagnosis (its README lists the thresholds, which are read from there): the likelihood ratio
against the level of the whole family of places, the share of what there is to explain, ties, and the shares that may be
left. Sizes near the one that was simulated follow from it by proportion: the remainders grow with the fault.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray
from scipy import stats

from armtwin.calib.diagnosis import diagnosis as verdict
from armtwin.calib.diagnosis import replacement, search, ties
from armtwin.calib.diagnosis.significance import LEVEL, LOUD
from armtwin.scenarios.power.contest import Contest, Key

Array = NDArray[np.float64]

DRAWS = 300
# Noncentrality from which a remainder that follows something is seen to, at the level of its tests.
_FOLLOWS = 60.0
NOTHING, UNKNOWN = "nothing", "unknown"


@dataclass(frozen=True)
class Answers:
    """What is said of worlds at one size: the share in which the fault is found, and how often each thing is said."""

    found: float
    said: Counter[str]


def answers(one: Contest, scale: float, rng: Generator, draws: int = DRAWS) -> Answers:
    """Play the rule on draws of the noise, for a fault `scale` times as large as the contest's."""
    gain, score, excess, left = _drawn(one, scale, rng, draws)
    said: Counter[str] = Counter()
    found = 0
    for k in range(draws):
        group = _named(one, scale, gain[k], score[k], float(excess[k]), left[k])
        found += one.keys[0] in group
        said["|".join(dict.fromkeys(name if isinstance(name, str) else name[0] for name in group))] += 1
    return Answers(found / draws, said)


def _drawn(one: Contest, scale: float, rng: Generator, draws: int) -> tuple[Array, Array, Array, Array]:
    """Gains (K, R) of the models over the geometry, their scores, the excess (K,), the remainder's excess (K, R)."""
    values, vectors = np.linalg.eigh(one.gram)
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    products = scale * rng.standard_normal((draws, len(root))) @ root.T
    taken = rng.chisquare(one.parameters, (draws, len(one.parameters)))
    distance = scale * scale * one.distance
    gain = distance[0] - distance[1:] + 2.0 * (products[:, :1] - products[:, 1:]) + taken
    noise = np.sqrt(2.0 * one.free) * rng.standard_normal(draws)
    excess = distance[0] + 2.0 * products[:, 0] + noise
    return gain, one.complexity - gain, excess, excess[:, None] - gain


def _named(
    one: Contest, scale: float, gain: Array, score: Array, excess: float, remaining: Array
) -> tuple[Key | str, ...]:
    """Return the group of models that one recording's answer names: several are a tie."""
    order = np.argsort(score)
    chosen = next(
        (
            int(m)
            for m in order
            if score[m] < score[order[0]] + search._ALIKE and _accepted(one, gain, m, excess, remaining)
        ),
        None,
    )
    if chosen is None:
        return (NOTHING,)
    best = int(order[0])
    tied = [int(m) for m in order if m == best or _tied(one, scale, best, int(m), score, excess, remaining)]
    simplest = min(tied, key=lambda m: (bool(one.untimed[m]), float(one.complexity[m]), float(score[m])))
    if gain[simplest] <= max(search._FIRST_SHARE * excess, _least_needed((one.tries - 1) * one.poses)):
        return (NOTHING,)
    if _unknown(one, scale, simplest):
        return (UNKNOWN,)
    others = [m for m in tied if m != simplest][: replacement._MOST_EQUIVALENTS]
    return tuple(one.keys[m] for m in (simplest, *others))


def _accepted(one: Contest, gain: Array, m: int, excess: float, remaining: Array) -> bool:
    k = int(one.parameters[m])
    left = max((one.free + float(remaining[m])) / one.free, 1.0)
    ratio = max(float(gain[m] - one.complexity[m]), 0.0) / left
    significant = ratio / k > _least_ratio(k, one.free, one.tries)
    return bool(significant and excess > 0.0 and gain[m] > search._FIRST_SHARE * excess)


def _tied(one: Contest, scale: float, best: int, other: int, score: Array, excess: float, remaining: Array) -> bool:
    difference = float(score[other] - score[best])
    if difference < max(ties._LEAST_DIFFERENCE, ties._PART_OF_REMAINDER * max(float(remaining[best]), 0.0)):
        return True
    a, b = best + 1, other + 1
    apart = max(float(one.gram[a, a] + one.gram[b, b] - 2.0 * one.gram[a, b]), 0.0)
    spread = 2.0 * scale * float(np.sqrt(apart))
    return difference < ties._SMALL_SHARE * excess and difference < ties._VUONG * spread


def _unknown(one: Contest, scale: float, m: int) -> bool:
    """Whether what the best model leaves of the fault is too much of it to be called the cause."""
    before, after = scale**2 * one.typical[0], scale**2 * one.typical[m + 1]
    left = after / max(before, 1e-12)
    follows = scale**2 * float(one.distance[m + 1]) > _FOLLOWS
    loud = 1.0 + after > LOUD
    return bool((left > verdict._FOLLOWING_SHARE and follows) or (left > verdict._LEFT_SHARE and loud))


# The thresholds are asked for thousands of times.
@cache
def _least_needed(tries: int) -> float:
    """The least gain of a cause that stays, over all rows and sites that were tried."""
    return float(stats.chi2.isf(LEVEL / tries, 1))


@cache
def _least_ratio(parameters: int, free: int, tries: int) -> float:
    """The F ratio at the level of the family."""
    return float(stats.f.isf(LEVEL / tries, parameters, free))
