"""A cause as data, written out once for `diagnosis.json`, a run's results and the score."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from armtwin.calib.diagnosis.diagnosis import NamedCause
from armtwin.models.catalogue.predict import Active


def place_of(active: Active) -> dict[str, Any]:
    """Return an effect by name, joint and marker."""
    return {"effect": active.effect.name, "joint": active.site.joint, "marker": active.site.marker}


def cause_table(
    cause: NamedCause, parameters: Any, place: Callable[[Active], dict[str, Any]] = place_of
) -> dict[str, Any]:
    """Return a cause with what is told of its parameters, and its equivalents, each at its `place`."""
    return {
        **place(cause.active),
        "parameters": parameters,
        "equivalents": [place(other) for other in cause.equivalents],
        "p_value": cause.p_value,
        "explained_percent": cause.explained_percent,
    }
