"""What a sweep's worlds add up to: sizes found with their intervals, what is said of what, coverage, cost."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from armtwin.models.statistics import Z95
from armtwin.scenarios.sweeps.curve import Curve, Found, wilson
from armtwin.scenarios.sweeps.placing import Placing, are_fixed, unit_of_size
from armtwin.scenarios.sweeps.table import Cell
from armtwin.scenarios.sweeps.trial import Row

SCHEMA = "armtwin.sizes/1"
Rows = Mapping[tuple[int, int], Row]


@dataclass(frozen=True, eq=False)
class CellSummary:
    """What the worlds of one cell say.

    Attributes:
        cell, unit: which, and in what its sizes are.
        rows: its finished worlds, without those that broke down; `broken` are so many.
        curve: of found against size; None where the cell has one size alone.
        half, ninety: the sizes found in 50 and in 90 of 100.
        confirmed: (found, of) worlds at `ninety` that did not place it.

    """

    cell: Cell
    unit: str
    rows: tuple[Row, ...]
    broken: int
    curve: Curve | None
    half: Found
    ninety: Found
    confirmed: tuple[int, int]

    @property
    def share(self) -> tuple[int, int]:
        """(found, of) all worlds."""
        return sum(row["found"] for row in self.rows), len(self.rows)


def summaries(placings: Iterable[Placing], rows: Rows, trials: int) -> list[CellSummary]:
    """Add up every cell's worlds; `trials` of each placed its sizes, those after them confirm."""
    out = []
    for placing in placings:
        cell = placing.cell
        mine = [row for (number, _), row in sorted(rows.items()) if number == cell.number]
        good = tuple(row for row in mine if row.get("error") is None)
        nothing = Found(None, None, None)
        one_size = cell.size is not None or not cell.effects or are_fixed(cell.effects)
        curve = None if one_size or not good else placing.curve(rows)
        later = [row["found"] for row in good if row["trial"] >= trials]
        out.append(
            CellSummary(
                cell=cell,
                unit=unit_of_size(cell.effects) if cell.effects else "",
                rows=good,
                broken=len(mine) - len(good),
                curve=curve,
                half=nothing if curve is None else curve.size_at(0.5),
                ninety=nothing if curve is None else curve.size_at(0.9),
                confirmed=(sum(later), len(later)),
            )
        )
    return out


def confusion(cells: Iterable[CellSummary], large: bool) -> dict[str, Counter[str]]:
    """Count what is said of each effect, in worlds of at least the size found in 90 of 100, or of smaller ones."""
    said: dict[str, Counter[str]] = {}
    for one in cells:
        limit = np.inf if one.ninety.size is None else one.ninety.size
        for row in one.rows:
            if one.curve is None or (row["size"] >= limit) == large:
                said.setdefault(one.cell.effect, Counter())[row["said"]] += 1
    return said


def coverage(cells: Iterable[CellSummary]) -> dict[str, tuple[int, int]]:
    """By `effect.parameter`, how many intervals of 95 % hold the truth, of those named outright at their place."""
    inside: dict[str, tuple[int, int]] = {}
    for row in (row for one in cells for row in one.rows):
        for miss in row["misses"]:
            hits, of = inside.get(miss["name"], (0, 0))
            inside[miss["name"]] = hits + (abs(miss["value"]) <= Z95), of + 1
    return dict(sorted(inside.items()))


def cost(rows: Rows) -> dict[str, float | None]:
    """Processor seconds a world: the median, nine tenths, and the sum of all in hours."""
    seconds = [sum(row["cost"].values()) for row in rows.values() if row.get("error") is None]
    if not seconds:
        return {"median_s": None, "p90_s": None, "hours": None}
    return {
        "median_s": float(np.median(seconds)),
        "p90_s": float(np.quantile(seconds, 0.9)),
        "hours": float(np.sum(seconds)) / 3600.0,
    }


def sizes_table(cells: Iterable[CellSummary], rows: Rows) -> dict[str, Any]:
    """Return the content of `sizes.json`."""
    cells = list(cells)
    return {
        "schema": SCHEMA,
        "worlds": len(rows),
        "broken": sum(one.broken for one in cells),
        "cells": [_cell_table(one) for one in cells],
        "coverage": coverage(cells),
    }


def _cell_table(one: CellSummary) -> dict[str, Any]:
    hits, of = one.share
    return {
        **one.cell.model_dump(mode="json", exclude={"effects", "size"}),
        "effect": one.cell.effect,
        "unit": one.unit,
        "worlds": of,
        "found": hits,
        "found_ci90": wilson(hits, of),
        "size_50": _found(one.half),
        "size_90": _found(one.ninety),
        "confirmed": one.confirmed,
    }


def _found(found: Found) -> dict[str, float | None]:
    return {"size": found.size, "low": found.low, "high": found.high}
