"""One outcome against the truth: was the right cause named, at the right place, and nothing else?"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from armtwin.models.catalogue.injection import declared
from armtwin.models.catalogue.motion_effect import motion_catalogue
from armtwin.models.catalogue.registry import catalogue
from armtwin.models.statistics import Z95

Table = Mapping[str, Any]

# A tie names no cause any more where it holds more than this.
MOST_TIED = 3


@dataclass(frozen=True)
class Judgement:
    """How a world was answered.

    Attributes:
        kind: null, single, pair or uncatalogued.
        truth, said: labels for people.
        right: every hidden effect is named (or in a tie of at most three), and nothing that is not there.
        found: number of hidden effects that were named.
        site_right: of those that sit at a joint, link or marker, how many were named there, and how many there are.
        wrong: a cause was named that is not there (no tie of it holds a hidden one).
        alarmed: something was said of a world that hides nothing.
        tied: size of the largest tie.
        misses: by `effect.parameter`, how far its value is from the truth, in its standard deviations.
        held_out_ratio: held-out error over the true noise, with medians in place of RMS second; None if not named.
        seconds: of the diagnosis.

    """

    kind: str
    truth: str
    said: str
    right: bool
    found: int
    hidden: int
    site_right: int
    sited: int
    wrong: bool
    alarmed: bool
    tied: int
    misses: Mapping[str, float]
    held_out_ratio: tuple[float, float] | None
    seconds: float

    @property
    def covered(self) -> dict[str, bool]:
        """By `effect.parameter`, whether value ± 1.96 std holds the truth."""
        return {name: abs(miss) <= Z95 for name, miss in self.misses.items()}


def judge(truth: Table, outcome: Table) -> Judgement:
    """Judge what was said of a world."""
    hidden, causes, verdict = truth["effects"], outcome["causes"], outcome["verdict"]
    groups = [[cause, *cause["equivalents"]] for cause in causes]
    expected = [effect for effect in hidden if not is_gauge(effect["effect"])]
    in_gauge = all(any(e["effect"] in words for words in outcome["gauge"]) for e in hidden if is_gauge(e["effect"]))
    found, site_right, sited = 0, 0, 0
    for effect in expected if truth["kind"] != "uncatalogued" else []:
        members = [m for group in groups if len(group) <= MOST_TIED for m in group if m["effect"] == effect["effect"]]
        if members:
            found += 1
            if effect["joint"] is not None or effect["marker"] is not None:
                sited += 1
                site_right += any(_same_site(effect, member) for member in members)
    names = {effect["effect"] for effect in expected}
    wrong = any(not names.intersection(member["effect"] for member in group) for group in groups)
    if truth["kind"] == "uncatalogued":
        right = verdict == "unknown"
    elif not expected:
        right = verdict == "none" and in_gauge
    else:
        right = found == len(expected) and not wrong and in_gauge
    return Judgement(
        kind=truth["kind"],
        truth=" + ".join(label(effect) for effect in hidden) or "nothing",
        said=_said(verdict, groups),
        right=right,
        found=found,
        hidden=len(expected),
        site_right=site_right,
        sited=sited,
        wrong=wrong,
        alarmed=truth["kind"] == "null" and verdict != "none",
        tied=max((len(group) for group in groups), default=0),
        misses=_misses(expected, causes),
        held_out_ratio=_held_out_ratio(truth, outcome) if right and causes else None,
        seconds=outcome["seconds"],
    )


def is_gauge(name: str) -> bool:
    """Whether the geometry takes an effect up altogether: it is no cause, its name has to stand in the gauge."""
    return name in catalogue() and catalogue()[name].gauge is not None


def label(effect: Table) -> str:
    """An effect and its place for people."""
    if effect.get("joint") is not None:
        return f"{effect['effect']} {effect['joint']}"
    return f"{effect['effect']} {str(effect['marker']).upper()}" if effect.get("marker") else str(effect["effect"])


def name_said(verdict: str, causes: Sequence[Table]) -> str:
    """The answer without places, for the confusion matrix."""
    if not causes:
        return verdict
    return " + ".join(sorted("|".join(dict.fromkeys(m["effect"] for m in (c, *c["equivalents"]))) for c in causes))


def _said(verdict: str, groups: Sequence[Sequence[Table]]) -> str:
    return " + ".join(" | ".join(label(member) for member in group) for group in groups) or verdict


def _same_site(effect: Table, member: Table) -> bool:
    partner = catalogue()[effect["effect"]].partner if effect["effect"] in catalogue() else None
    if partner is not None:
        return {effect["marker"], effect["parameters"][partner]} == {member["marker"], member.get(partner)}
    return bool(effect["joint"] == member["joint"] and effect["marker"] == member["marker"])


def _misses(expected: Sequence[Table], causes: Sequence[Table]) -> dict[str, float]:
    """Misses of the causes that were named outright at the right place."""
    misses = {}
    for effect in expected:
        known = catalogue().get(effect["effect"]) or motion_catalogue().get(effect["effect"])
        injected = () if known is None else known.injected
        for cause in causes:
            if cause["effect"] != effect["effect"] or not _same_site(effect, cause):
                continue
            intervals, true = cause["parameters"], effect["parameters"]
            if any(i.get("switch") and round(i["value"]) != true.get(n, 0) for n, i in intervals.items()):
                continue  # the same motion stated in another frame has other numbers
            for name, interval in intervals.items():
                real = true.get(name, interval.get("off"))
                on_bench = declared(injected, name)
                if interval.get("switch") or real is None or on_bench is None or interval["std"] is None:
                    continue  # no number, or one that the bench that made the world does not have
                miss = interval["value"] - real
                if on_bench.period is not None:
                    miss -= on_bench.period * round(miss / on_bench.period)
                misses[f"{effect['effect']}.{name}"] = miss / max(interval["std"], 1e-12)
    return misses


def _held_out_ratio(truth: Table, outcome: Table) -> tuple[float, float] | None:
    """RMS and median of the held-out errors over what the true noise alone would give."""
    held_out = outcome["held_out"]
    if held_out["after_rms_mm"] is None or not held_out["noise_floor_mm"]:
        return None
    floor = held_out["noise_floor_mm"] * truth["noise_px"] / outcome["noise"]
    median_floor = floor * np.sqrt(np.log(2.0))  # a Rayleigh distribution's median over its RMS
    return held_out["after_rms_mm"] / floor, held_out["after_median_mm"] / float(median_floor)
