"""Diagnose every log of a sealed set of moving arms, judge the answers as those of poses at rest, and add them up."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from armtwin.scenarios.scoring.judge import Judgement, judge
from armtwin.scenarios.scoring.moving_outcome import LogTask, diagnose_log, kept_log_outcome, moving_version
from armtwin.scenarios.scoring.pool import gathered
from armtwin.scenarios.scoring.summary import Rate, rates

_HELD_OUT_FLOORS = 1.15


@dataclass(frozen=True, eq=False)
class MovingScore:
    """A scored set of logs: truth, outcome and judgement of each, and what broke down."""

    truths: Mapping[str, Mapping[str, Any]]
    outcomes: Mapping[str, Mapping[str, Any]]
    judgements: Mapping[str, Judgement]
    broken: Mapping[str, str]


def score_moving(
    out: Path, truths: Mapping[str, Mapping[str, Any]], jobs: int, progress: Callable[[int, int], None]
) -> MovingScore:
    """Diagnose the logs of `out` and judge the answers; outcomes of the same code are taken from disk."""
    version = moving_version()
    tasks = {name: LogTask(out, int(name), version) for name in truths}
    kept = {name: kept_log_outcome(task) for name, task in tasks.items()}
    outcomes: dict[str, Mapping[str, Any]] = {name: found for name, found in kept.items() if found is not None}
    left = [(name, task) for name, task in tasks.items() if name not in outcomes]
    broken = gathered(diagnose_log, left, outcomes, jobs, progress)
    judgements = {name: judge_log(truths[name], outcomes[name]) for name in sorted(outcomes)}
    return MovingScore(truths, outcomes, judgements, broken)


def judge_log(truth: Mapping[str, Any], outcome: Mapping[str, Any]) -> Judgement:
    """Judge what was said of a log."""
    nothing = {"after_rms_mm": None, "noise_floor_mm": None}
    judged = judge(truth, {**outcome, "gauge": [], "held_out": nothing})
    if not (judged.right and outcome["causes"]):
        return judged
    return replace(judged, held_out_ratio=_over_floor(truth["noise_rad"], outcome["held_out"]))


def moving_rates(judgements: Sequence[Judgement]) -> dict[str, Rate]:
    """Return the rates of a set of logs by name, each with what is wanted of it."""
    found = rates(judgements)
    four = [j for j in judgements if j.kind == "quad"]
    known = [j for j in judgements if j.kind in ("single", "pair", "quad")]
    everything = [*known, *(j for j in judgements if j.kind == "uncatalogued")]
    ratios = [j.held_out_ratio[0] for j in judgements if j.held_out_ratio is not None]
    within = sum(ratio <= _HELD_OUT_FLOORS for ratio in ratios)
    title = f"named: held-out error at most {_HELD_OUT_FLOORS} floors"
    return {
        **found,
        "wrong": Rate("wrong names, known effects", sum(j.wrong for j in known), len(known), most=0.02),
        "wrong_all": replace(found["wrong_all"], hits=sum(j.wrong for j in everything), total=len(everything)),
        "false_alarms": replace(found["false_alarms"], most=0.0),
        "both": replace(found["both"], least=0.90),
        "four": Rate("all of four effects", sum(j.found == j.hidden for j in four), len(four), least=0.75),
        "held_out": Rate(title, within, len(ratios), least=0.5),
    }


def _over_floor(noise_rad: Sequence[float], held_out: Sequence[Mapping[str, Any]]) -> tuple[float, float] | None:
    """RMS of the held-out errors over the true noise, and the median over joints and trajectories."""
    pairs = [
        (float(one["after_rms_rad"]), noise_rad[int(one["joint"]) - 1])
        for one in held_out
        if one.get("after_rms_rad") is not None
    ]
    if not pairs:
        return None
    errors, floors = np.array(pairs).T
    return float(np.sqrt(np.mean(errors**2) / np.mean(floors**2))), float(np.median(errors / floors))
