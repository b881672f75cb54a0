"""One effect at one place: the size from which a plan finds it, averaged over the forms that it may take."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from armtwin.models.catalogue.registry import effect_named
from armtwin.models.catalogue.site import Site
from armtwin.scenarios.power.arms import Arms
from armtwin.scenarios.power.contest import Key, intervals
from armtwin.scenarios.power.events import event_answers
from armtwin.scenarios.power.form import Form, Hiding, Rivals, crossing, form_of
from armtwin.scenarios.power.kinds import drawn_kinds
from armtwin.scenarios.power.rule import Answers, answers
from armtwin.scenarios.sweeps.curve import wilson
from armtwin.sim.sealed import Wanted
from armtwin.sim.sealed.of_size import draw_at, is_fixed, unit_of

Array = NDArray[np.float64]

# Sizes at which the curve is told.
_SIZES = 25
_SHARES = (0.5, 0.9)
# The curve is told from this far below the sizes that were simulated to this far above them.
_BELOW, _ABOVE = 3.0, 1.7
# An effect of single events is looked at from a noise to a hundred pixels, each half the way to where it is found.
_EVENT_PX, _MOST_EVENT_PX = 1.0, 100.0
_EVENT_SIZES = 12


@dataclass(frozen=True)
class PlacePower:
    """What a plan can see of an effect at a place.

    Attributes:
        effect, site, unit: which, and in what its sizes are told.
        sizes, found: the curve; low, high: its least and most over the forms of the fault.
        size_50, size_90: found in so many of 100 recordings; None where no size within what is hidden is.
        taken_for: what is said at half of size_90, as shares.
        estimates: parameter -> (value, standard deviation) at size_90.
        moves: RMS motion of a coordinate that the geometry leaves of it at size_90, in noises.
        rivals: (rival, share of what the fault explains that tells the two apart, score difference at size_90).
        fixed: the fault comes in one size alone, so that the curve is one share, at size 1.
        why_not: why it cannot be seen at all, otherwise empty.

    """

    effect: str
    site: Site
    unit: str
    sizes: tuple[float, ...] = ()
    found: tuple[float, ...] = ()
    low: tuple[float, ...] = ()
    high: tuple[float, ...] = ()
    size_50: float | None = None
    size_90: float | None = None
    taken_for: dict[str, float] = field(default_factory=dict)
    estimates: dict[str, tuple[float, float]] = field(default_factory=dict)
    moves: float | None = None
    rivals: tuple[tuple[Key, float, float], ...] = ()
    fixed: bool = False
    why_not: str = ""

    @property
    def share(self) -> float:
        """Share of the recordings in which a fault of one size alone is found."""
        return self.found[0]


def power_at(arms: Arms, effect: str, site: Site, forms: int, near: float | None = None) -> PlacePower:
    """Work out what the plan of a setting sees of an effect at a place; `near` is a size at which to look first."""
    rng = np.random.default_rng(np.random.SeedSequence(arms.seed, spawn_key=_spawn(effect, site)))
    _, scene = arms.bench(0, effect)
    hidden = draw_at(rng, scene, Wanted(effect, _EVENT_PX, site))
    unit = unit_of(hidden)
    said = effect_named(effect)
    if said.gauge is not None:
        return PlacePower(effect, site, unit, why_not="the geometry takes it up altogether: it is told as a gauge")
    fixed = is_fixed(effect, scene)
    if not said.is_fitted:
        return _of_events(arms, effect, site, unit, rng, fixed)
    rivals, made, seed = Rivals(arms, effect), list[Form](), int(rng.integers(2**32))
    for number, (drawn, weight) in enumerate(drawn_kinds(rng, scene, effect, site, forms)):
        hiding = Hiding(effect, *arms.bench(number, effect), drawn, weight)
        form = form_of(hiding, site, rivals, near, seed)
        if form is not None:
            made.append(form)
            near = form.size_90 or near
    if not made:
        return PlacePower(effect, site, unit, why_not="these poses do not show it at any size that is hidden")
    if fixed:
        return _of_one_size(effect, site, made, rng)
    return _summed(effect, site, unit, made, hidden.most, rng)


def _summed(effect: str, site: Site, unit: str, forms: list[Form], most: float, rng: np.random.Generator) -> PlacePower:
    simulated = [look.size for form in forms for look in form.looks]
    sizes = np.geomspace(min(simulated) / _BELOW, min(max(simulated) * _ABOVE, most), _SIZES)
    seed = int(rng.integers(2**32))
    told = [[form.at(float(size), seed) for form in forms] for size in sizes]
    weights = [form.weight for form in forms]
    found = np.array([np.average([one.found for one in row], weights=weights) for row in told])
    size_50, size_90 = (crossing(sizes, found, share) for share in _SHARES)
    about = size_90 or float(sizes[-1])
    said = _weighed([form.at(0.5 * about, seed) for form in forms], weights)
    look = min((form.nearest(about) for form in forms), key=lambda one: abs(np.log(one.size / about)))
    scale, one = about / look.size, look.contest
    explained = float(one.distance[0] - one.distance[1])
    apart = [float(one.distance[m] - one.distance[1]) for m in range(2, len(one.distance))]
    rivals = tuple((key, d / explained, scale**2 * d) for key, d in zip(one.keys[1:], apart, strict=True))
    return PlacePower(
        effect=effect,
        site=site,
        unit=unit,
        sizes=tuple(map(float, sizes)),
        found=tuple(map(float, found)),
        low=tuple(min(one.found for one in row) for row in told),
        high=tuple(max(one.found for one in row) for row in told),
        size_50=size_50,
        size_90=size_90,
        taken_for=said,
        estimates=dict(intervals(look.data, look.models[0])),
        moves=scale * float(np.sqrt(one.distance[0] / one.values)),
        rivals=rivals,
    )


def _weighed(told: Sequence[Answers], weights: Sequence[float]) -> dict[str, float]:
    """Return how often each thing is said, the most frequent first, of forms that come as often as they weigh."""
    said: dict[str, float] = {}
    for one, weight in zip(told, weights, strict=True):
        for name, count in one.said.items():
            said[name] = said.get(name, 0.0) + weight / sum(weights) * count / one.said.total()
    return dict(sorted(said.items(), key=lambda item: -item[1]))


def _of_one_size(effect: str, site: Site, forms: list[Form], rng: np.random.Generator) -> PlacePower:
    told = [answers(form.looks[0].contest, 1.0, rng) for form in forms]
    shares, weights = [one.found for one in told], [form.weight for form in forms]
    return PlacePower(
        effect=effect,
        site=site,
        unit="",
        sizes=(1.0,),
        found=(float(np.average(shares, weights=weights)),),
        low=(min(shares),),
        high=(max(shares),),
        taken_for=_weighed(told, weights),
        fixed=True,
    )


def _of_events(arms: Arms, effect: str, site: Site, unit: str, rng: np.random.Generator, fixed: bool) -> PlacePower:
    """Return the same for what is found sample by sample: the diagnosis' own finders on draws of the noise."""
    told: dict[float, Answers] = {}

    def is_found(size: float) -> bool:
        told[size] = event_answers(arms, effect, site, size, rng)
        return told[size].found >= _SHARES[1]

    if fixed:
        is_found(1.0)
    else:
        bisect_left(np.geomspace(arms.setting.noise_px, _MOST_EVENT_PX, _EVENT_SIZES).tolist(), True, key=is_found)
    told = dict(sorted(told.items()))
    sizes = np.array(list(told))
    bands = [wilson(one.said[effect], sum(one.said.values())) for one in told.values()]
    found = np.array([one.found for one in told.values()])
    size_50, size_90 = (None if fixed else crossing(sizes, found, share) for share in _SHARES)
    below = max((k for k, size in enumerate(sizes) if size < (size_90 or np.inf)), default=0)
    said = told[float(sizes[below])].said
    total = sum(said.values())
    return PlacePower(
        effect=effect,
        site=site,
        unit=unit,
        sizes=tuple(map(float, sizes)),
        found=tuple(map(float, found)),
        low=tuple(low for low, _ in bands),
        high=tuple(high for _, high in bands),
        size_50=size_50,
        size_90=size_90,
        taken_for={name: count / total for name, count in said.most_common()},
        fixed=fixed,
    )


def _spawn(effect: str, site: Site) -> tuple[int, ...]:
    """Return a key of random numbers that belongs to one effect and place."""
    return tuple(f"{effect} {site}".encode())
