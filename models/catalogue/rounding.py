"""Lattices in rounding errors: which steps and origins make rounded commands of what a residual shows.

A command rounded to a lattice is off by a sawtooth of the command itself. The sawtooth's first harmonic stands out of
the residual's spectrum over 1/step as a line, whose phase is the lattice's origin: one transform looks at every step
and origin at once. Each joint has its own.

Once the step is nearly known, every measured angle says on which point of the lattice it lies, and so between which two
commands the border of that point's cell must run: step and origin are then bounded by the commands alone.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.optimize import linprog

from armtwin.models.catalogue.registry import Evidence

Array = NDArray[np.float64]

LARGEST_STEP_RAD = 0.3
# A twentieth of a degree: finer steps are below what any of these servos, or a camera on them, resolves.
SMALLEST_STEP_RAD = 6e-4
# A lattice has to take this much off the logarithm of a joint's likelihood, twice: about twice the logarithm of the
# steps and origins that are looked at.
_BEYOND_CHANCE = 40.0
# What lies on the steps of the readings, or on finer ones, is their grain.
_OF_THE_GRAIN = 1.2
# Servos of one arm mostly share their step: of one that another joint has only the origin is looked for.
_BEYOND_CHANCE_SHARED = 16.0
# Rounding to a step scatters angles by step / sqrt(12) about a smooth curve of the command; in few poses by half of it.
_LEAST_SCATTER = 0.5 / np.sqrt(12.0)
_CURVE_DEGREE = 3
# Samples of the commanded angle to the smallest step, and of the spectrum to one line's width.
_PER_STEP = 6
_PER_LINE = 4
_LINES = 10
_HARMONICS = 4
# Rows that the lines are compared on; more change no order.
_MOST_ROWS = 800
_SWEEPS = 2
# The best lines' cells are looked at, by the commands nearest to their borders; a step may be stretched by so much.
_BOUNDED = 3
_BORDERING = 400
_STRETCH = 0.1


@dataclass(frozen=True)
class Rounding:
    """A lattice: commands land on whole multiples of `step_rad` counted from `origin_rad`."""

    step_rad: float
    origin_rad: float

    def errors(self, commands: Array) -> Array:
        """(N,) what rounding adds to commands (N,)."""
        return rounded(commands, self.step_rad, self.origin_rad) - commands


def rounded(commands: Array, step_rad: float, origin_rad: float) -> Array:
    """(N,) commands on a lattice."""
    out: Array = np.round((commands - origin_rad) / step_rad) * step_rad + origin_rad
    return out


def roundings(evidence: Evidence) -> list[Rounding | None]:
    """Return the lattice of each joint's commands that the residual shows, or None."""
    n = evidence.commands.shape[1]
    found: list[Rounding | None] = [None] * n
    for _ in range(_SWEEPS):
        for joint in range(n):
            q = evidence.commands[:, joint]
            departures, weights = _departures(evidence, found, joint)
            found[joint] = _rounding(
                evidence.grain_rad,
                q,
                departures,
                weights,
                [r.step_rad for k, r in enumerate(found) if r is not None and k != joint],
            )
    return found


def _departures(evidence: Evidence, found: list[Rounding | None], but: int) -> tuple[Array, Array]:
    """(N,) departures of one joint and their weights, once the other joints' lattices are taken off."""
    pull = evidence.pull.copy()
    for joint, rounding in enumerate(found):
        if rounding is not None and joint != but:
            pull -= evidence.stiffness[:, :, joint] * rounding.errors(evidence.commands[:, joint])[:, None]
    return replace(evidence, pull=pull).departures(but)


def _rounding(grain_rad: float, q: Array, departures: Array, weights: Array, others: list[float]) -> Rounding | None:
    counted = weights > 0
    q, e, w = q[counted], departures[counted], weights[counted]
    if len(q) < 12 or np.ptp(q) == 0:
        return None
    e = e - np.average(e, weights=w)
    some = np.linspace(0, len(q) - 1, min(len(q), _MOST_ROWS)).astype(int)

    def left(one: Rounding) -> float:
        return _left(q, e, w, one)

    def gain(one: Rounding) -> float:
        return len(q) * float(np.log(_spread(e, w) / max(left(one), 1e-300)))

    def best_of(lines: list[Rounding]) -> Rounding | None:
        fine = [_refined(q[some], e[some], w[some], line) for line in lines]
        best = sorted(fine, key=left)[:_BOUNDED]
        return min([*fine, *(one for line in best for one in _bounded(q, e, line))], key=left, default=None)

    shared = best_of([Rounding(step, 0.0) for step in others])
    own = best_of(_lines(q, e, w))
    prices = [(shared, _BEYOND_CHANCE_SHARED), (own, _BEYOND_CHANCE)]
    worth = [(gain(one) - price, one) for one, price in prices if one is not None]
    most, found = max(worth, key=lambda pair: pair[0], default=(0.0, None))
    if found is None or most <= 0.0 or found.step_rad < _OF_THE_GRAIN * grain_rad:
        return None
    if _scatter(q, e, w) < _LEAST_SCATTER * found.step_rad:
        return None
    return found


def _scatter(q: Array, e: Array, w: Array) -> float:
    """Return how far departures lie off a smooth curve of the command, rad.

    Marks that a person chose, and sought the commands for, lie as regularly as a lattice, but on a smooth curve.
    """
    degree = min(_CURVE_DEGREE, len(np.unique(np.round(q / SMALLEST_STEP_RAD))) - 1)
    curve = np.polynomial.Polynomial.fit(q, e, degree, w=np.sqrt(w))
    return float(np.sqrt(_spread(e - curve(q), w)))


def _spread(e: Array, w: Array) -> float:
    middle = np.average(e, weights=w)
    return float(np.average((e - middle) ** 2, weights=w))


def _left(q: Array, e: Array, w: Array, rounding: Rounding) -> float:
    """Weighted variance that a lattice leaves; a joint's zero takes up the mean."""
    return _spread(e - rounding.errors(q), w)


def _lines(q: Array, e: Array, w: Array) -> list[Rounding]:
    """Return the lattices whose sawtooth explains most, by its harmonics."""
    width = SMALLEST_STEP_RAD / _PER_STEP
    cells = np.round((q - q.min()) / width).astype(int)
    size = int(2 ** np.ceil(np.log2(_PER_LINE * (cells.max() + 1))))
    signal = np.bincount(cells, weights=w * e, minlength=size)
    spectrum = np.fft.rfft(signal)
    per_rad = np.fft.rfftfreq(size, width)  # 1 / step
    wanted = (per_rad >= 1.0 / LARGEST_STEP_RAD) & (per_rad <= 1.0 / SMALLEST_STEP_RAD)
    step = 1.0 / np.maximum(per_rad, 1e-9)
    # A sawtooth of unit step has harmonics of 1 / (pi m); uneven commands shift some of the first one's to the others.
    harmonics = np.zeros_like(spectrum.real)
    for m in range(1, _HARMONICS + 1):
        number = np.arange(0, len(spectrum), m)
        harmonics[: len(number)] += np.abs(spectrum)[number] / m
    gain = np.where(wanted, 2.0 * step / np.pi * harmonics - w.sum() * step * step / 12.0, -np.inf)
    peaks = np.flatnonzero((gain[1:-1] >= gain[:-2]) & (gain[1:-1] > gain[2:])) + 1
    found = []
    for k in peaks[np.argsort(-gain[peaks])][:_LINES]:
        if gain[k] > 0:
            phase = float(np.angle(spectrum[k])) - 2 * np.pi * float(per_rad[k]) * float(q.min())
            found.append(Rounding(float(step[k]), (0.5 * np.pi - phase) / (2 * np.pi * float(per_rad[k]))))
    return found


def _refined(q: Array, e: Array, w: Array, line: Rounding) -> Rounding:
    """Return the best of a grid about a line, finer and finer; origins are counted near the commands' middle."""
    middle = float(np.median(q))
    step, phase = line.step_rad, (line.origin_rad - middle) / line.step_rad
    reach, turn = 0.5 * step / np.ptp(q), 0.5
    best = Rounding(step, middle + phase * step)
    least = _left(q, e, w, best)
    for _ in range(4):
        steps = best.step_rad * (1.0 + reach * np.linspace(-1, 1, 13))
        phases = (best.origin_rad - middle) / best.step_rad + turn * np.linspace(-1, 1, 13)
        for one in steps:
            x = (q - middle) / one - phases[:, None]
            errors = e - (np.round(x) - x) * one
            means = errors @ w / w.sum()
            left = ((errors - means[:, None]) ** 2) @ w / w.sum()
            k = int(np.argmin(left))
            if left[k] < least:
                least, best = float(left[k]), Rounding(float(one), middle + float(phases[k]) * float(one))
        reach, turn = reach / 4, turn / 4
    return best


def _bounded(q: Array, e: Array, rounding: Rounding) -> list[Rounding]:
    """Return the lattices whose cells hold the commands of the points that are measured, far from all borders.

    One has the step that is measured, another one any: the two differ where a servo's gain is off as well.
    """
    step, origin = rounding.step_rad, rounding.origin_rad
    at = q + e
    counts = np.round((q - origin) / step)
    for _ in range(3):
        if np.ptp(counts) == 0:
            return []
        slope, zero = (float(x) for x in np.polyfit(counts, at, 1))
        if not 1.0 - _STRETCH < slope / step < 1.0 + _STRETCH:
            return []
        counts = np.round((at - zero) / slope)
    counts += np.round(np.median((q - origin) / step - counts))
    some = _nearest_to_borders(q, counts, step, origin)
    widths = ((slope, slope), ((1.0 - _STRETCH) * step, (1.0 + _STRETCH) * step))
    return [one for width in widths if (one := _cells(q[some], counts[some], width)) is not None]


def _cells(q: Array, counts: Array, width: tuple[float, float]) -> Rounding | None:
    """Return the lattice of a step within `width` whose cells `counts` hold the commands q, or as many as can be.

    |q - origin - step * count| <= step / 2 - margin + slack: the margin is as wide, the slacks as small as they can be.
    """
    one = np.ones(len(q))
    above = np.column_stack([-counts - 0.5, -one, one])
    below = np.column_stack([counts - 0.5, one, one])
    cells: Any = sparse.csr_array(np.concatenate([above, below]))
    slack: Any = -sparse.vstack([sparse.eye_array(len(q)), sparse.eye_array(len(q))])
    solution = linprog(
        np.concatenate([[0.0, 0.0, -1.0], one]),
        A_ub=sparse.hstack([cells, slack], format="csr"),
        b_ub=np.concatenate([-q, q]),
        bounds=[width, (None, None), (0.0, width[1]), *[(0.0, None)] * len(q)],
    )
    return Rounding(*map(float, solution.x[:2])) if solution.success and solution.x is not None else None


def _nearest_to_borders(q: Array, counts: Array, step: float, origin: float) -> NDArray[np.intp]:
    """Rows whose commands lie nearest to the borders of their cells: only those bound the lattice."""
    to_border = 0.5 * step - np.abs(q - origin - step * counts)
    return np.argsort(to_border)[:_BORDERING]
