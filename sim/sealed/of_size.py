"""Draw a sealed world whose effect has a given size, in its own unit, rather than a given displacement."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.random import Generator

from armtwin.models.arm import Arm
from armtwin.models.catalogue.sealed import Hidden
from armtwin.models.catalogue.site import Site
from armtwin.models.errors import InputError
from armtwin.models.plan import Plan
from armtwin.sim.sealed.displacement import Scene
from armtwin.sim.sealed.draw import Sealed, bench_of, hide, plain, record, sealing_of, truth_of

# Draws until one falls on the place that is wanted; the rarest falls on one in a dozen.
_DRAWS = 400
# An effect that comes in single events has no amplitude: its size is how far it moves the markers, px.
EVENT_UNIT = "px"
EVENT_PX = 1.0


@dataclass(frozen=True)
class Wanted:
    """An effect to be hidden: its name, its size, and its place (anywhere where None).

    The size is in the effect's own unit, or `relative`: in multiples of the amplitude at which its sealed draw starts.
    """

    effect: str
    size: float
    place: Site | None = None
    relative: bool = False

    def amplitude(self, hidden: Hidden) -> float:
        """Return the amplitude, at most the largest that is hidden; an effect of single events has but one."""
        wanted = self.size * hidden.start if self.relative else self.size
        return hidden.start if is_event(hidden) else min(wanted, hidden.most)


def draw_of_size(
    rng: Generator,
    wanted: Sequence[Wanted],
    *,
    plan: tuple[Plan, tuple[str, ...]] | None = None,
    arm: Arm | None = None,
    n_poses: int | None = None,
    noise_px: float | None = None,
    markers: Sequence[str] | None = None,
    declare_noise: bool | None = None,
) -> Sealed:
    """Draw a world with effects of given sizes and record it; what is None is drawn, as for `draw_world`.

    `plan` holds the poses and the names of the held-out trajectories. Raises `InputError` for an unknown effect, or a
    place where it is never drawn.
    """
    names = [one.effect for one in wanted]
    bench, scene = bench_of(rng, names, arm, n_poses, noise_px, markers, plan)
    world, effects = bench, list[dict[str, Any]]()
    for one in wanted:
        hidden = draw_at(rng, scene, one)
        amplitude = one.amplitude(hidden)
        world = hide(world, one.effect, hidden, amplitude)
        effects.append(
            {
                "effect": one.effect,
                "joint": hidden.site.joint,
                "marker": hidden.site.marker,
                "parameters": plain(hidden.parameters(amplitude)),
            }
        )
    return Sealed(record(rng, world, scene, declare_noise=declare_noise), truth_of(world, scene, effects, None), world)


def draw_at(rng: Generator, scene: Scene, wanted: Wanted) -> Hidden:
    """Draw an effect's shape at the place that is wanted; raises `InputError` where it is never drawn there."""
    size_px = EVENT_PX * wanted.size if wanted.relative else wanted.size
    sealing, situation = sealing_of(wanted.effect), scene.situation(size_px)
    for _ in range(_DRAWS):
        hidden = sealing.draw(rng, situation)
        if wanted.place is None or hidden.site == wanted.place:
            return hidden
    raise InputError(f"effect '{wanted.effect}' is hidden at no place '{place_name(wanted.place)}' of this arm")


def is_event(hidden: Hidden) -> bool:
    """Whether an effect has no amplitude: it moves the markers as far as it does."""
    return hidden.start == hidden.most


def is_fixed(effect: str, scene: Scene) -> bool:
    """Whether an effect has no size at all: whatever is asked for, the same is drawn."""
    small, large = (draw_at(np.random.default_rng(0), scene, Wanted(effect, size)) for size in (1.0, 50.0))
    return is_event(small) and small.parameters(small.start) == large.parameters(large.start)


def unit_of(hidden: Hidden) -> str:
    """Return the unit in which an effect's size is told: that of the first parameter that grows with it."""
    if is_event(hidden):
        return EVENT_UNIT
    one, other = hidden.parameters(hidden.start), hidden.parameters(0.5 * hidden.start)
    key = next(name for name, value in one.items() if value != other[name])
    for unit, text in _UNITS.items():
        if key.endswith(unit):
            return text
    return ""


# By the end of a parameter's name; what ends in none of these is a plain number.
_UNITS = {"_rad_per_nm": "rad/Nm", "_per_nm2": "1/Nm²", "_rad": "rad", "_mm": "mm", "_px": "px", "_kg": "kg", "_s": "s"}


def place_name(site: Site | None) -> str:
    """Return a place as a table states it: `joint 2`, `marker b`, `whole` or `any`."""
    if site is None:
        return "any"
    if site.joint is not None:
        return f"joint {site.joint}"
    return "whole" if site.marker is None else f"marker {site.marker}"
