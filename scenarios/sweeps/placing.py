"""Where the next worlds of a cell are placed: at the sizes where the answer changes, near 50 and 90 %.

A cell asks for its worlds round by round, and a round's sizes follow from the outcomes of the rounds before it alone,
so that neither the order in which worlds finish nor a run that was broken off changes what is asked.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache

import numpy as np

from armtwin.models.plan import Plan
from armtwin.scenarios.sweeps.curve import Curve
from armtwin.scenarios.sweeps.table import Cell, SweepTable
from armtwin.scenarios.sweeps.trial import Row, Trial, plan_of_cell
from armtwin.sim.sealed import Wanted, bench_of
from armtwin.sim.sealed.of_size import draw_at, is_event, is_fixed, unit_of

# The first round is a ladder over three decades up to the largest size that is hidden; later ones are small.
_DECADES = 3.0
_LADDER = 7
_ROUND = 6
# Quantiles of what is believed of the sizes at 50 and 90 %, by which a round is spread.
_AT = ((0.5, 0.25), (0.5, 0.75), (0.9, 0.15), (0.9, 0.4), (0.9, 0.6), (0.9, 0.85))
# An effect of single events is asked for by how far it moves the markers, px, up to this.
_MOST_EVENT_PX = 100.0
_FEW_POSES = 24


class Placing:
    """The worlds of one cell, asked for round by round."""

    def __init__(self, table: SweepTable, cell: Cell) -> None:
        self.cell = cell
        self._table = table
        self._plan: Plan | None = plan_of_cell(cell)
        self._given = cell.size is not None or not cell.effects or are_fixed(cell.effects)
        self._asked: list[Trial] = []
        self._round: list[Trial] = []

    @property
    def least(self) -> float:
        """The least size that is looked at."""
        return self.most * 10.0**-_DECADES

    @property
    def most(self) -> float:
        """The largest size that is looked at, in the unit of the cell's sizes."""
        return largest_size(self.cell.effects)

    def next_round(self, rows: Mapping[tuple[int, int], Row]) -> list[Trial]:
        """Return the next worlds, none when the cell is done or a world of the round before has no row yet."""
        if any(trial.key not in rows for trial in self._round):
            return []
        sizes = self._sizes(rows)
        begun = len(self._asked)
        made = [Trial(self.cell, begun + k, size, self._table.seed, self._plan) for k, size in enumerate(sizes)]
        self._asked += made
        self._round = made
        return made

    def _sizes(self, rows: Mapping[tuple[int, int], Row]) -> list[float]:
        done, table = len(self._asked), self._table
        if self._given:
            return [] if done else [self.cell.size or 1.0] * table.trials
        if done >= table.trials:
            confirmed = done >= table.trials + table.confirm
            at = None if confirmed else self.curve(rows).size_at(0.9).size
            return [] if at is None else [float(min(at, self.most))] * table.confirm
        if done == 0:
            return [float(x) for x in np.geomspace(self.least, self.most, min(_LADDER, table.trials))]
        curve = self.curve(rows)
        wanted = [curve.quantiles_at(share, (level,))[0] for share, level in _AT]
        sizes = [self.most if size is None else float(np.clip(size, self.least, self.most)) for size in wanted]
        return sizes[: table.trials - done]

    def curve(self, rows: Mapping[tuple[int, int], Row]) -> Curve:
        """Return what the worlds that placed the sizes say; those that confirm do not count."""
        known = [rows[t.key] for t in self._asked[: self._table.trials] if t.key in rows]
        known = [row for row in known if row.get("error") is None]
        sizes = np.array([row["size"] for row in known])
        return Curve(sizes, np.array([row["found"] for row in known], dtype=bool), self.least, self.most)


@cache
def are_fixed(effects: tuple[str, ...]) -> bool:
    """Whether effects come in one size alone."""
    _, scene = bench_of(np.random.default_rng(0), effects, n_poses=_FEW_POSES)
    return all(is_fixed(name, scene) for name in effects)


@cache
def unit_of_size(effects: tuple[str, ...]) -> str:
    """Return the unit of a cell's sizes."""
    if len(effects) > 1:
        return "times usual"
    _, scene = bench_of(np.random.default_rng(0), effects, n_poses=_FEW_POSES)
    return unit_of(draw_at(np.random.default_rng(0), scene, Wanted(effects[0], 1.0)))


@cache
def largest_size(effects: tuple[str, ...]) -> float:
    """Return the largest size that effects are hidden with, in the unit of a cell's sizes."""
    _, scene = bench_of(np.random.default_rng(0), effects, n_poses=_FEW_POSES)
    most = np.inf
    for name in effects:
        hidden = draw_at(np.random.default_rng(0), scene, Wanted(name, 1.0))
        largest = _MOST_EVENT_PX if is_event(hidden) else hidden.most
        most = min(most, largest / hidden.start if len(effects) > 1 and not is_event(hidden) else largest)
    return float(most)
