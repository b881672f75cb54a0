"""The faults that a visitor may put into a simulated bench, as the effects declare them."""

from __future__ import annotations

from typing import Any

from armtwin.models.arm import Arm
from armtwin.models.catalogue.injection import Stated, taken_by
from armtwin.models.catalogue.registry import Effect, effect_named
from armtwin.models.catalogue.site import Site
from armtwin.models.errors import InputError
from armtwin.models.validation import row
from armtwin.scenarios.scenario import EffectTable


def declaration(effect: Effect, arm: Arm) -> dict[str, Any]:
    """Return what a form needs: name, meaning, where it may sit, and each parameter with its bounds."""
    numbers = list(range(1, arm.n_joints + 1))
    return {
        "name": effect.name,
        "summary": effect.summary,
        "joints": numbers if effect.where in ("joint", "link") else [],
        "markers": list(arm.marker_names) if effect.where == "marker" else [],
        "parameters": [
            {
                "name": name,
                "kind": one.kind,
                "bounds": list(one.bounds),
                "default": one.default,
                "required": one.required,
            }
            for name, one in taken_by(effect.injected, arm).items()
        ],
    }


def checked_fault(fault: EffectTable, number: int, arm: Arm) -> EffectTable:
    """Return a fault whose parameters the bench can be given; raises `InputError` for one that it cannot."""
    effect = effect_named(fault.name)
    try:
        effect.check(Stated(fault.parameters, Site(fault.joint, fault.marker), f"{row('faults', number)}: "), arm)
    except InputError as error:
        raise InputError(f"faults: {error}") from None
    return fault
