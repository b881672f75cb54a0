"""What the diagnosis named beside what was injected."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from scenarios.runner.job import Job
from scenarios.runner.truth import truth_table

_KEY = ("effect", "joint", "marker")


def diagnosis_results(job: Job) -> dict[str, Any]:
    """Return the content of diagnosis.json, its words, and each cause beside the truth."""
    stage = job.load("diagnose")
    return {
        **stage["found"],
        "words": stage["words"],
        "corrected_with": stage["corrected_with"],
        "beside_truth": beside_truth(stage["causes"], truth_table(job.scenario)["effects"]),
    }


def beside_truth(causes: list[dict[str, Any]], injected: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """List every named cause with the truth of each parameter (null: not stated), then what was not named.

    A cause is right where an effect of its name was injected at its place, or one that it is said to tie with.
    """
    rows = []
    left = list(injected)
    for cause in causes:
        truth = next((effect for effect in left if _is_same(cause, effect)), None)
        tied = next((effect for effect in left if any(_is_same(other, effect) for other in cause["equivalents"])), None)
        for effect in (truth, tied):
            if effect is not None and effect in left:
                left.remove(effect)
        rows.append(
            {
                **{key: cause[key] for key in (*_KEY, "label", "explained_percent", "equivalents")},
                "right": truth is not None or tied is not None,
                "parameters": [_beside(parameter, truth) for parameter in cause["parameters"]],
            }
        )
    return [*rows, *(_not_named(effect) for effect in left)]


def _is_same(cause: Mapping[str, Any], effect: Mapping[str, Any]) -> bool:
    return all(cause[key] == effect[key] for key in _KEY)


def _beside(parameter: dict[str, Any], truth: dict[str, Any] | None) -> dict[str, Any]:
    value = None if truth is None else truth["parameters"].get(parameter["name"], parameter["unstated"])
    return {**{key: parameter[key] for key in ("name", "value", "std", "interval95")}, "truth": value}


def _not_named(effect: dict[str, Any]) -> dict[str, Any]:
    nothing = {"value": None, "std": None, "interval95": None}
    return {
        **{key: effect[key] for key in _KEY},
        "label": None,
        "explained_percent": None,
        "equivalents": [],
        "right": False,
        "parameters": [{"name": name, **nothing, "truth": value} for name, value in effect["parameters"].items()],
    }
