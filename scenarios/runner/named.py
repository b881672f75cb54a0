"""What the diagnosis named beside what was injected, and beside what the camera's calibration left."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from armtwin.models.camera import Camera
from armtwin.models.catalogue.registry import catalogue
from armtwin.scenarios.runner.camera import calibrated_camera
from armtwin.scenarios.runner.job import Job
from armtwin.scenarios.runner.truth import truth_table
from armtwin.scenarios.runner.world import true_camera

_KEY = ("effect", "joint", "marker")


def diagnosis_results(job: Job) -> dict[str, Any]:
    """Return the content of diagnosis.json, its words, and each cause beside the truth."""
    stage = job.load("diagnose")
    return {
        **stage["found"],
        "words": stage["words"],
        "beside_truth": beside_truth(
            stage["causes"],
            truth_table(job.scenario)["effects"],
            left_by_calibration(calibrated_camera(job), true_camera(job.scenario)),
        ),
    }


def left_by_calibration(assumed: Camera, true: Camera) -> list[dict[str, Any]]:
    """State the errors of a calibrated camera as the effects that they are, in the terms of the catalogue."""
    return [
        {"effect": name, "joint": None, "marker": None, "parameters": effect.left_by_calibration(assumed, true)}
        for name, effect in catalogue().items()
        if effect.left_by_calibration is not None
    ]


def beside_truth(
    causes: list[dict[str, Any]], injected: list[dict[str, Any]], calibration: list[dict[str, Any]]
) -> list[dict[str, Any]]:
    """List every named cause with the truth of each parameter (null: not stated), then what was not named.

    A cause's origin is "injected" where an effect of its name was injected at its place, or one that it is said to tie
    with; "calibration" where the camera's calibration left some of it; and null where there is no such thing.
    """
    rows = []
    left = list(injected)
    for cause in causes:
        truth = next((effect for effect in left if _is_same(cause, effect)), None)
        tied = next((effect for effect in left if any(_is_same(other, effect) for other in cause["equivalents"])), None)
        for effect in (truth, tied):
            if effect is not None and effect in left:
                left.remove(effect)
        origin = None if truth is None and tied is None else "injected"
        if origin is None:
            truth = next((effect for effect in calibration if _is_same(cause, effect)), None)
            origin = None if truth is None else "calibration"
        rows.append(
            {
                **{key: cause[key] for key in (*_KEY, "label", "explained_percent", "equivalents")},
                "origin": origin,
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
        "origin": "injected",
        "parameters": [{"name": name, **nothing, "truth": value} for name, value in effect["parameters"].items()],
    }
