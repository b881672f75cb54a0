"""Jumps in a series: the rows from which on its mean is another one."""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

# What a further jump has to take off N log(variance): four times the logarithm of a recording's rows.
_BEYOND_CHANCE = 30.0
_ROUNDS = 8
# A joint that stands elsewhere for fewer rows than this, or than one in so many, did not slip there and back.
_LEAST_ROWS = 4
_ONE_IN = 40


def jumps(values: Array, weights: Array, most: int) -> list[tuple[int, float]]:
    """Return at most `most` (row, jump) of (N,) values with weights, in order: each jump is worth its two numbers.

    One after the other is added where it explains most, and all are moved to their best places given the others.
    """
    counted = np.flatnonzero(weights > 0)
    if len(counted) < 8:
        return []
    y, w = values[counted], weights[counted]
    cuts: list[int] = []
    best, least = cuts, len(y) * np.log(_left(y, w, cuts) + 1e-300)
    for number in range(1, most + 1):  # a jump and its way back are worth little one without the other
        cuts = _settled(y, w, [*cuts, _best_cut(y, w, cuts)])
        cost = len(y) * np.log(_left(y, w, cuts) + 1e-300) + _BEYOND_CHANCE * number
        if cost < least:
            best, least = cuts, cost
    cuts = best
    means = _means(y, w, cuts)
    return [(int(counted[cut]), float(means[k + 1] - means[k])) for k, cut in enumerate(cuts)]


def _settled(y: Array, w: Array, cuts: list[int]) -> list[int]:
    for _ in range(_ROUNDS):
        moved = list(cuts)
        for cut in cuts:
            moved.remove(cut)
            moved.append(_best_cut(y, w, moved))
        if sorted(moved) == sorted(cuts):
            break
        cuts = moved
    return sorted(set(cuts))


def _best_cut(y: Array, w: Array, cuts: list[int]) -> int:
    """Row at which one more cut lowers the weighted sum of squares most."""
    edges = [0, *sorted(cuts), len(y)]
    run = max(_LEAST_ROWS, len(y) // _ONE_IN)
    best, row = -1.0, run
    for low, high in itertools.pairwise(edges):
        if high - low < 2 * run:
            continue
        mass = np.cumsum(w[low:high])
        moment = np.cumsum(w[low:high] * y[low:high])
        a, b = mass[:-1], mass[-1] - mass[:-1]
        between = a * b / mass[-1] * (moment[:-1] / a - (moment[-1] - moment[:-1]) / b) ** 2
        between[: run - 1], between[len(between) - run + 1 :] = -1.0, -1.0
        k = int(np.argmax(between))
        if between[k] > best:
            best, row = float(between[k]), low + k + 1
    return row


def _means(y: Array, w: Array, cuts: list[int]) -> list[float]:
    edges = [0, *cuts, len(y)]
    return [float(np.average(y[a:b], weights=w[a:b])) for a, b in itertools.pairwise(edges)]


def _left(y: Array, w: Array, cuts: list[int]) -> float:
    sizes = np.diff([0, *cuts, len(y)])
    return float(w @ (y - np.repeat(_means(y, w, cuts), sizes)) ** 2)
