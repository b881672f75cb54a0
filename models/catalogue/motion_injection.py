"""An effect is made in the world of a moving arm: its parameters checked and completed, and its injector called."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from armtwin.models.catalogue.injection import Stated, checked
from armtwin.models.catalogue.motion_effect import MotionEffect, motion_effect_named
from armtwin.models.catalogue.site import NOWHERE, Site
from armtwin.models.errors import InputError
from armtwin.models.motion_world import MotionWorld

# An effect by its name, where it sits, and its parameters.
MotionCause = tuple[str, Site, Mapping[str, Any]]


def inject_in_motion(world: MotionWorld, name: str, parameters: Mapping[str, Any], site: Site = NOWHERE) -> MotionWorld:
    """Return the world with an effect made in it; one of a joint that names none sits at every joint alike.

    Raises `InputError` for an effect that is unknown or that nothing makes, a joint that the arm does not have, and a
    parameter that is unknown, missing or beyond what is possible.
    """
    effect = motion_effect_named(name)
    if effect.injector is None:
        raise InputError(f"{name}: nothing makes it in the world of a moving arm")
    for place in _places(world, effect, site):
        stated = Stated(parameters, place, at=f"{name}: ")
        world = effect.injector(world, checked(name, effect.where, effect.injected, stated, world.arm), place)
    return world


def with_causes(world: MotionWorld, causes: Sequence[MotionCause]) -> MotionWorld:
    """Return the world with several effects made in it."""
    for name, site, parameters in causes:
        world = inject_in_motion(world, name, parameters, site)
    return world


def _places(world: MotionWorld, effect: MotionEffect, site: Site) -> list[Site]:
    if effect.where == "joint" and site.joint is None:
        return [Site(joint=index + 1) for index in range(world.arm.n_joints)]
    return [site]
