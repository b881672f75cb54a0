"""An effect as it shows in a moving arm: which numbers of the servo's loop it changes, and how it is made physically.

An effect that holds for poses at rest and for motion has both in its one file: `EFFECT`, and `IN_MOTION` beside it.
What only a moving arm shows has `IN_MOTION` alone. The estimator changes slots of `armtwin.models.motion.loop`; the
injector changes the world that MuJoCo moves. The two share no formula.
"""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

from armtwin.models.catalogue.injection import Injected
from armtwin.models.catalogue.site import Site
from armtwin.models.errors import InputError, nearest, shown

# Returns the moving arm's world with the effect made in it, from checked parameters.
MotionInjector = Callable[[Any, Mapping[str, Any], Site], Any]


@dataclass(frozen=True)
class Slot:
    """A parameter of an effect and the slot of the loop that it fills.

    Attributes:
        parameter: its name with its unit, as it stands in every file.
        slot: name in `armtwin.models.motion.loop.NEUTRAL`.
        bounds: what is physically possible, of the slot.
        starts: values of the slot from which a fit begins.
        scale: a size of the slot that matters, for steps of derivatives.
        scanned: the angles are no smooth function of it.
        factor: the parameter in its own unit for each unit of the slot.

    """

    parameter: str
    slot: str
    bounds: tuple[float, float]
    starts: tuple[float, ...]
    scale: float
    scanned: bool = False
    factor: float = 1.0


# What a joint is sent through to tell causes apart: swings that grow quicker, single steps between rests, slow turns
# there and back, and angles that are held, approached from both sides.
MOTIONS = ("chirp", "steps", "reversals", "holds")


@dataclass(frozen=True, kw_only=True)
class MotionEffect:
    """One cause of error of a moving arm.

    Attributes:
        name, summary: as in `Effect`.
        where: a joint, or the whole arm.
        forms: the forms that it has, each as what it changes of a joint's loop; none for one that is found otherwise.
        further: what a form may have beyond, offered step by step once the effect was found.
        confused_with, experiment: as in `Effect`.
        motions: which of a joint's motions show it: of `MOTIONS`.
        needs_load: it shows only where the loads are known and vary.
        injector: makes it physically; None where nothing makes it yet.
        injected: the parameters that the injector takes.
        sealed: how it is hidden in a sealed log; None: it is not.

    """

    name: str
    summary: str
    where: Literal["joint", "arm"]
    forms: tuple[tuple[Slot, ...], ...] = ()
    further: tuple[tuple[Slot, ...], ...] = ()
    confused_with: tuple[str, ...] = ()
    experiment: str = ""
    motions: tuple[str, ...] = MOTIONS
    needs_load: bool = False
    injector: MotionInjector | None = None
    injected: tuple[Injected, ...] = ()
    sealed: Any = None


@dataclass
class _Loaded:
    effects: dict[str, MotionEffect] = field(default_factory=dict)


_LOADED = _Loaded()


def motion_catalogue() -> Mapping[str, MotionEffect]:
    """Return every effect that a moving arm can have, by name: one file of `armtwin.models.effects` each."""
    if not _LOADED.effects:
        package = importlib.import_module("armtwin.models.effects")
        for module in pkgutil.iter_modules(package.__path__):
            effect = getattr(importlib.import_module(f"armtwin.models.effects.{module.name}"), "IN_MOTION", None)
            if isinstance(effect, MotionEffect):
                _LOADED.effects[effect.name] = effect
    return _LOADED.effects


def motion_effect_named(name: str) -> MotionEffect:
    """Return an effect of a moving arm; raises `InputError` with the nearest valid name."""
    known = motion_catalogue()
    if name not in known:
        raise InputError(f"no effect '{shown(name)}' of a moving arm{nearest(name, known)}")
    return known[name]
