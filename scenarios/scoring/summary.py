"""Rates over a sealed set, each with its target, its numerator and its denominator."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from armtwin.scenarios.scoring.judge import Judgement


@dataclass(frozen=True)
class Rate:
    """`hits` of `total`; `least` and `most` bound the share that is wanted."""

    title: str
    hits: int
    total: int
    least: float = 0.0
    most: float = 1.0

    @property
    def share(self) -> float | None:
        """The rate, or None where there was nothing to count."""
        return self.hits / self.total if self.total else None

    @property
    def met(self) -> bool | None:
        """Whether the target is met, or None where there was nothing to count."""
        return None if self.share is None else self.least <= self.share <= self.most


def rates(judgements: Sequence[Judgement]) -> dict[str, Rate]:
    """Return the rates of a set by name."""
    single = [j for j in judgements if j.kind == "single"]
    named = [j for j in single if j.found]
    pairs = [j for j in judgements if j.kind == "pair"]
    null = [j for j in judgements if j.kind == "null"]
    strange = [j for j in judgements if j.kind == "uncatalogued"]
    ratios = [j.held_out_ratio[0] for j in judgements if j.held_out_ratio is not None]
    covered = [holds for j in judgements for holds in j.covered.values()]
    known = [*single, *pairs]
    return {
        "right": Rate("right cause, or in a tie of at most three", _count(single, "right"), len(single), least=0.95),
        "site": Rate("of those, right joint or marker", _sum(named, "site_right"), _sum(named, "sited"), least=0.95),
        "wrong": Rate("wrong names, known effects", _count(known, "wrong"), len(known), most=0.02),
        "wrong_all": Rate("wrong names, unknown faults too", _count([*known, *strange], "wrong"), len(known + strange)),
        "false_alarms": Rate("false alarms where nothing is hidden", _count(null, "alarmed"), len(null), most=0.01),
        "unknown": Rate("uncatalogued faults called unknown", _count(strange, "right"), len(strange), least=0.90),
        "both": Rate("both of two effects", sum(j.found == j.hidden for j in pairs), len(pairs), least=0.85),
        "coverage": Rate("parameters inside their 95 % interval", sum(covered), len(covered), least=0.92, most=0.98),
        "held_out": Rate("named: held-out error at most 1.1 floors", sum(r <= 1.1 for r in ratios), len(ratios)),
        "ties": Rate("right answers that are ties", sum(j.right and j.tied > 1 for j in known), _count(known, "right")),
    }


def held_out_figures(judgements: Sequence[Judgement]) -> dict[str, float | None]:
    """Quantiles over worlds of the held-out error over the noise floor, for rightly named worlds."""
    pairs = np.array([j.held_out_ratio for j in judgements if j.held_out_ratio is not None])
    if not len(pairs):
        return {"median": None, "p90": None, "pooled": None, "median_of_medians": None}
    rms, medians = pairs.T
    return {
        "median": float(np.median(rms)),
        "p90": float(np.quantile(rms, 0.9)),
        "pooled": float(np.sqrt(np.mean(rms**2))),
        "median_of_medians": float(np.median(medians)),
    }


def coverage_by_parameter(judgements: Sequence[Judgement]) -> dict[str, tuple[int, int]]:
    """Inside and all, by `effect.parameter`."""
    counts: dict[str, list[bool]] = {}
    for judgement in judgements:
        for name, holds in judgement.covered.items():
            counts.setdefault(name, []).append(holds)
    return {name: (sum(holds), len(holds)) for name, holds in sorted(counts.items())}


def confusion(pairs: Sequence[tuple[str, str]]) -> dict[str, dict[str, int]]:
    """Counts by what is true and what was said, without places."""
    table: dict[str, Counter[str]] = {}
    for true, said in pairs:
        table.setdefault(true, Counter())[said] += 1
    return {true: dict(counts.most_common()) for true, counts in sorted(table.items())}


def as_table(rate: Rate) -> Mapping[str, Any]:
    """Return a rate as data."""
    return {
        "title": rate.title,
        "hits": rate.hits,
        "of": rate.total,
        "least": rate.least,
        "most": rate.most,
        "share": rate.share,
        "met": rate.met,
    }


def _count(judgements: Sequence[Judgement], what: str) -> int:
    return sum(bool(getattr(j, what)) for j in judgements)


def _sum(judgements: Sequence[Judgement], what: str) -> int:
    return sum(int(getattr(j, what)) for j in judgements)
