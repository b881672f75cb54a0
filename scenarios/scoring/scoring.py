"""Diagnose every world of a sealed set, judge the answers and add them up."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from armtwin.models.arm import nominal_arm
from armtwin.models.errors import InputError
from armtwin.scenarios.scoring.geometry import geometry_covered
from armtwin.scenarios.scoring.judge import Judgement, is_gauge, judge, name_said
from armtwin.scenarios.scoring.outcome import Task, code_version, diagnose_world, kept_outcome
from armtwin.scenarios.scoring.pool import gathered
from armtwin.scenarios.scoring.sealing import read_truth, world_folder
from armtwin.scenarios.scoring.summary import as_table, confusion, coverage_by_parameter, held_out_figures, rates

SCHEMA = "armtwin.score/1"


@dataclass(frozen=True, eq=False)
class Score:
    """A scored set: truth and outcome of each world that was diagnosed, its judgement, and what broke down."""

    truths: Mapping[str, Mapping[str, Any]]
    outcomes: Mapping[str, Mapping[str, Any]]
    judgements: Mapping[str, Judgement]
    broken: Mapping[str, str]


def score(out: Path, jobs: int, progress: Callable[[int, int], None] = lambda done, total: None) -> Score:
    """Diagnose the worlds of `out` and judge the answers; outcomes of the same code are taken from disk."""
    truths: dict[str, dict[str, Any]] = read_truth(out)["worlds"]
    version = code_version()
    outcomes: dict[str, dict[str, Any]] = {}
    tasks = []
    for name in truths:
        if not (world_folder(out, int(name)) / "samples.csv").is_file():
            raise InputError(f"{world_folder(out, int(name))}: no recording, but truth.json has a world {name}")
        task = Task(out, int(name), version)
        kept = kept_outcome(task)
        if kept is None:
            tasks.append((name, task))
        else:
            outcomes[name] = kept
    broken = gathered(diagnose_world, tasks, outcomes, jobs, progress)
    judgements = {name: judge(truths[name], outcomes[name]) for name in sorted(outcomes)}
    return Score(truths, outcomes, judgements, broken)


def score_table(result: Score) -> dict[str, Any]:
    """Return the content of `score.json`."""
    judged = list(result.judgements.values())
    seconds = [j.seconds for j in judged]
    arm = nominal_arm()
    geometry = [
        holds
        for name, outcome in result.outcomes.items()
        if result.judgements[name].right
        and not any(is_gauge(effect["effect"]) for effect in result.truths[name]["effects"])
        and "base_x_mm" in outcome["geometry"]
        for holds in geometry_covered(arm, result.truths[name], outcome["geometry"]).values()
    ]
    return {
        "schema": SCHEMA,
        "worlds": len(result.truths),
        "rates": {name: as_table(rate) for name, rate in rates(judged).items()},
        "held_out_over_floor": held_out_figures(judged),
        "coverage_by_parameter": coverage_by_parameter(judged),
        "geometry_coverage": [sum(geometry), len(geometry)],
        "confusion": confusion(confusion_pairs(result)),
        "seconds": {"median": _quantile(seconds, 0.5), "p90": _quantile(seconds, 0.9), "most": _quantile(seconds, 1.0)},
        "judgements": {name: asdict(judgement) for name, judgement in result.judgements.items()},
        "broken": dict(result.broken),
    }


def confusion_pairs(result: Score) -> list[tuple[str, str]]:
    """(what is true, what was said) of every world, without places."""
    out = []
    for name, outcome in result.outcomes.items():
        truth = result.truths[name]
        true = " + ".join(sorted(effect["effect"] for effect in truth["effects"])) or "nothing"
        out.append(
            (f"({true})" if truth["kind"] == "uncatalogued" else true, name_said(outcome["verdict"], outcome["causes"]))
        )
    return out


def _quantile(values: list[float], share: float) -> float | None:
    return float(np.quantile(values, share)) if values else None
