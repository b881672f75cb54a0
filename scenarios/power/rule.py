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

from armtwin.calib.diagnosis.acceptance import ALIKE, FIRST_SHARE
from armtwin.calib.diagnosis.diagnosis import FOLLOWING_SHARE, LEFT_SHARE, PLAIN_NOISE, PLAIN_SHARE
from armtwin.calib.diagnosis.replacement import MOST_EQUIVALENTS
from armtwin.calib.diagnosis.significance import LEVEL, LOUD
from armtwin.calib.diagnosis.ties import LEAST_DIFFERENCE, PART_OF_REMAINDER, SMALL_SHARE, VUONG
from armtwin.scenarios.power.contest import Contest

Array = NDArray[np.float64]
Bool = NDArray[np.bool_]

DRAWS = 300
# Noncentrality from which a remainder that follows something is seen to, at the level of its tests.
_FOLLOWS = 60.0
NOTHING, UNKNOWN = "nothing", "unknown"


@dataclass(frozen=True)
class Answers:
    """What is said of worlds at one size: the share in which the fault is found, and how often each thing is said."""

    found: float
    said: Counter[str]


@dataclass(frozen=True, eq=False)
class _Drawn:
    """K draws of the noise: what each of R models gains over the geometry, its score, what it leaves, all (K, R).

    `excess` (K,) is what there is to explain.
    """

    gain: Array
    score: Array
    remaining: Array
    excess: Array


def answers(one: Contest, scale: float, rng: Generator, draws: int = DRAWS) -> Answers:
    """Play the rule on draws of the noise, for a fault `scale` times as large as the contest's."""
    drawn = _drawn(one, scale, rng, draws)
    simplest, tied = _named(one, scale, drawn)
    named = simplest >= 0
    unknown = _unknown(one, scale)
    said: Counter[str] = Counter({NOTHING: int((~named).sum())})
    found = 0
    for models, count in Counter(map(tuple, _groups(simplest[named], tied[named], drawn.score[named]))).items():
        if unknown[models[0]]:
            said[UNKNOWN] += count
            continue
        found += count * (0 in models)
        said["|".join(dict.fromkeys(one.keys[m][0] for m in models))] += count
    return Answers(found / draws, +said)


def _drawn(one: Contest, scale: float, rng: Generator, draws: int) -> _Drawn:
    values, vectors = np.linalg.eigh(one.gram)
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    products = scale * rng.standard_normal((draws, len(root))) @ root.T
    taken = rng.chisquare(one.parameters, (draws, len(one.parameters)))
    distance = scale * scale * one.distance
    gain = distance[0] - distance[1:] + 2.0 * (products[:, :1] - products[:, 1:]) + taken
    noise = np.sqrt(2.0 * one.free) * rng.standard_normal(draws)
    excess = distance[0] + 2.0 * products[:, 0] + noise
    return _Drawn(gain, one.complexity - gain, excess[:, None] - gain, excess)


def _named(one: Contest, scale: float, drawn: _Drawn) -> tuple[NDArray[np.intp], Bool]:
    """(K,) the model that each recording's answer names, -1 for none, and (K, R) those that tie with the best."""
    rows = np.arange(len(drawn.excess))
    best = np.argmin(drawn.score, axis=1)
    lowest = drawn.score[rows, best]
    alike = drawn.score < (lowest + ALIKE)[:, None]
    accepted = (_accepted(one, drawn) & alike).any(axis=1)
    tied = _tied(one, scale, best, drawn)
    tied[rows, best] = True
    # What was recorded speaks for a cause before its simplicity, and that before its score.
    price = np.where(tied, 1e9 * one.untimed + 1e4 * one.complexity + (drawn.score - lowest[:, None]), np.inf)
    simplest = np.argmin(price, axis=1)
    least = np.maximum(FIRST_SHARE * drawn.excess, _least_needed((one.tries - 1) * one.poses))
    stays = accepted & (drawn.gain[rows, simplest] > least)
    return np.where(stays, simplest, -1), tied


def _groups(simplest: NDArray[np.intp], tied: Bool, score: Array) -> list[tuple[int, ...]]:
    """Return the models that each answer names, the simplest first, then the best of those that tie with it."""
    groups = []
    for first, others, scores in zip(simplest, tied, score, strict=True):
        rest = [int(m) for m in np.argsort(scores) if others[m] and m != first]
        groups.append((int(first), *rest[:MOST_EQUIVALENTS]))
    return groups


def _accepted(one: Contest, drawn: _Drawn) -> Bool:
    """(K, R) whether each model explains significantly, and a real share."""
    least = np.array([_least_ratio(int(k), one.free, one.tries) for k in one.parameters])
    left = np.maximum((one.free + drawn.remaining) / one.free, 1.0)
    ratio = np.maximum(drawn.gain - one.complexity, 0.0) / left / one.parameters
    excess = drawn.excess[:, None]
    return np.asarray((ratio > least) & (excess > 0.0) & (drawn.gain > FIRST_SHARE * excess))


def _tied(one: Contest, scale: float, best: NDArray[np.intp], drawn: _Drawn) -> Bool:
    """(K, R) whether each model cannot be told from the best."""
    rows = np.arange(len(best))
    difference = drawn.score - drawn.score[rows, best][:, None]
    misfits = drawn.remaining - drawn.remaining[rows, best][:, None]
    least = np.maximum(LEAST_DIFFERENCE, PART_OF_REMAINDER * np.maximum(drawn.remaining[rows, best], 0.0))[:, None]
    gram, runs = one.gram[1:, 1:], one.runs[1:]
    apart = np.maximum(np.diag(gram) + np.diag(gram)[:, None] - 2.0 * gram, 0.0)
    uneven = (runs[:, None] - runs).std(axis=-1, ddof=1) ** 2 * runs.shape[-1]
    spread = np.sqrt(4.0 * scale**2 * apart + scale**4 * uneven)[best]
    told = (difference >= least) & ~(one.as_free[best] & (misfits < least))
    by_few = (difference < SMALL_SHARE * drawn.excess[:, None]) & (difference < VUONG * spread)
    return np.asarray(~told | by_few)


def _unknown(one: Contest, scale: float) -> Bool:
    """(R,) whether what each model leaves of the fault is too much of it to be called the cause."""
    before, after = scale**2 * one.typical[0], scale**2 * one.typical[1:]
    left = after / max(before, 1e-12)
    follows = scale**2 * one.distance[1:] > _FOLLOWS
    following = (left > FOLLOWING_SHARE) & follows
    plain = (left > PLAIN_SHARE) & (1.0 + after > PLAIN_NOISE)
    return np.asarray(following | plain | ((left > LEFT_SHARE) & (1.0 + after > LOUD)))


# The thresholds are asked for thousands of times.
@cache
def _least_needed(tries: int) -> float:
    """The least gain of a cause that stays, over all rows and sites that were tried."""
    return float(stats.chi2.isf(LEVEL / tries, 1))


@cache
def _least_ratio(parameters: int, free: int, tries: int) -> float:
    """The F ratio at the level of the family."""
    return float(stats.f.isf(LEVEL / tries, parameters, free))
