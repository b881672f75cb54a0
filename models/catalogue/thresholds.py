"""Thresholds of a servo that ignores small changes: which of them make what a joint's departures show.

The cost of a threshold is a staircase with basins a few hundredths wide, and the part by which a motor stops short
moves the stairs. So all thresholds and parts are driven along the commands at once, and the best basins are looked at
finely.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

# Parts of the threshold by which the motor stops short, on the first grid.
_SHORTS = (0.0, 0.06, 0.12, 0.18, 0.24, 0.3, 0.36, 0.42, 0.48)
_MOST_SHORT = 0.5
# Between neighbouring thresholds: a recording of some hundred poses tells apart a few in a hundred.
_RATIO = 1.04
# Basins that are looked at finely, how finely, and how often.
_BASINS = 3
_FINE = 9
_ROUNDS = 3


def held(path: Array, thresholds: Array, shorts: Array) -> Array:
    """(N, S) angles that S servos hold along a path (N,) of commands; each stops short by its part of its threshold."""
    at = np.full(len(thresholds), path[0])
    rest = shorts * thresholds
    out = np.empty((len(path), len(thresholds)))
    for row, angle in enumerate(path.tolist()):
        ahead = angle - at
        at = np.where(np.abs(ahead) >= thresholds, angle - np.sign(ahead) * rest, at)
        out[row] = at
    return out


def thresholds_in(path: Array, departures: Array, weights: Array, widest: float, least: float) -> list[Array]:
    """Return (threshold, part) of the best basins, best first, of what departures (N,) of a servo's path (N,) show."""
    moves = np.abs(np.diff(path))
    moves = moves[(moves > least) & (moves < widest)]
    if not len(moves) or not weights.any():
        return []
    smallest = float(moves.min())  # below it nothing is ignored
    count = int(np.ceil(np.log(widest / smallest) / np.log(_RATIO))) + 1
    grid = np.stack(np.meshgrid(np.geomspace(smallest, widest, count), _SHORTS, indexing="ij"), axis=-1).reshape(-1, 2)
    cost = _cost(path, departures, weights, grid)
    found = []
    for _ in range(_BASINS):
        k = int(np.argmin(cost))
        if not np.isfinite(cost[k]):
            break
        near = np.abs(np.log(grid[:, 0] / grid[k, 0])) < 3.0 * np.log(_RATIO)
        cost = np.where(near, np.inf, cost)
        found.append(_fine(path, departures, weights, grid[k], widest))
    found.sort(key=lambda pair: pair[0])
    return [values for _, values in found]


def _cost(path: Array, departures: Array, weights: Array, servos: Array) -> Array:
    """(S,) weighted variance that each of S servos (S, 2) leaves; a joint's zero takes up the mean."""
    left = (departures + path)[:, None] - held(path, servos[:, 0], servos[:, 1])
    mean = weights @ left / weights.sum()
    out: Array = weights @ (left - mean) ** 2 / weights.sum()
    return out


def _fine(path: Array, departures: Array, weights: Array, best: Array, widest: float) -> tuple[float, Array]:
    """Return cost and values of the best servo near another, in the middle of the thresholds that ignore the same."""
    reach, apart = np.log(_RATIO), _SHORTS[1] - _SHORTS[0]
    least = float(_cost(path, departures, weights, best[None])[0])
    for _ in range(_ROUNDS):
        wide = best[0] * np.exp(reach * np.linspace(-1.0, 1.0, _FINE))
        short = np.clip(best[1] + apart * np.linspace(-1.0, 1.0, _FINE), 0.0, _MOST_SHORT)
        near = np.stack(np.meshgrid(np.minimum(wide, widest), short, indexing="ij"), axis=-1).reshape(-1, 2)
        cost = _cost(path, departures, weights, near)
        k = int(np.argmin(cost))
        if cost[k] < least:
            least, best = float(cost[k]), near[k]
        reach, apart = reach / 3.0, apart / 3.0
    return least, _in_the_middle(path, best)


def _in_the_middle(path: Array, servo: Array) -> Array:
    """Return a servo that moves alike, its threshold amid the changes that it ignores and those that it follows."""
    threshold, short = servo.tolist()
    at = held(path, servo[:1], servo[1:])[:, 0]
    changes = np.abs(path[1:] - at[:-1])
    low = float(changes[changes < threshold].max(initial=short * threshold))
    high = float(changes[changes >= threshold].min(initial=threshold))
    middle = 0.5 * (low + high)
    return np.array([middle, min(short * threshold / middle, _MOST_SHORT)]) if middle > 0.0 else servo
