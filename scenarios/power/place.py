"""One effect at one place: the size from which a plan finds it, averaged over the forms that it may take."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from armtwin.calib.diagnosis.candidates import CandidateModel
from armtwin.calib.diagnosis.fit import Data, Fit
from armtwin.models.catalogue.registry import Effect, effect_named
from armtwin.models.catalogue.site import Site
from armtwin.scenarios.power.contest import Contest, Key, base_fit, contest, intervals, own_models, rivals_of
from armtwin.scenarios.power.events import event_answers
from armtwin.scenarios.power.rule import Answers, answers
from armtwin.scenarios.power.setting import Setting, data_without_noise
from armtwin.scenarios.sweeps.curve import wilson
from armtwin.sim.sealed import Wanted, hide
from armtwin.sim.sealed.of_size import draw_at, is_event, is_fixed, unit_of

Array = NDArray[np.float64]

# Sizes at which the curve is told.
_SIZES = 25
_SHARES = (0.5, 0.9)
# Deviance that a cause must explain to be found nine times of ten: its test's level and the noise's own spread.
_AIM, _AIM_SPREADS = 40.0, 1.4
# Sizes are looked at by this factor, until one is found and one is not.
_STEPS, _NEAR = 3, 1.7
_FEW_DRAWS = 100
# An effect of single events is looked at from a noise to a hundred pixels.
_EVENT_PX = (1.0, 100.0)
_EVENT_SIZES = 6


@dataclass(frozen=True, eq=False)
class Look:
    """A form of a fault at one size: the data without noise, their geometry, the models that could stand for it."""

    size: float
    data: Data
    base: Fit
    models: tuple[CandidateModel, ...]
    contest: Contest


@dataclass(frozen=True, eq=False)
class Form:
    """A form of a fault on one arm as it might be built, at rising sizes about that at which it is found."""

    looks: tuple[Look, ...]

    def at(self, size: float, seed: int) -> Answers:
        """Answers at a size, from the nearest that was simulated; always by the same draws of the noise."""
        near = self.nearest(size)
        return answers(near.contest, size / near.size, np.random.default_rng(seed))

    def nearest(self, size: float) -> Look:
        """Return the look whose size is nearest."""
        return min(self.looks, key=lambda look: abs(np.log(look.size / size)))


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


def power_at(setting: Setting, effect: str, site: Site, seed: int, forms: int) -> PlacePower:
    """Work out what the plan of a setting sees of an effect at a place."""
    rng = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=_spawn(effect, site)))
    _, scene = setting.bench(rng, effect)
    hidden = draw_at(rng, scene, Wanted(effect, _EVENT_PX[0], site))
    unit = unit_of(hidden)
    said = effect_named(effect)
    if said.gauge is not None:
        return PlacePower(effect, site, unit, why_not="the geometry takes it up altogether: it is told as a gauge")
    fixed = is_fixed(effect, scene)
    if not said.is_fitted:
        return _of_events(setting, effect, site, unit, rng, fixed)
    rivals = _Rivals()
    made = [one for _ in range(forms) if (one := _form(setting, effect, site, rng, rivals)) is not None]
    if not made:
        return PlacePower(effect, site, unit, why_not="these poses do not show it at any size that is hidden")
    if fixed:
        return _of_one_size(effect, site, made, rng)
    return _summed(effect, site, unit, made, hidden.most, rng)


class _Rivals:
    """The effects and places of the whole catalogue that come near a fault: looked for once, where it is found."""

    def __init__(self) -> None:
        self.pairs: list[tuple[Effect, Site]] | None = None

    def beside(self, one: Look) -> Look:
        """Return a look with the rivals in it."""
        found = rivals_of(one.data, one.base, one.models[0], self.pairs)
        if self.pairs is None:
            self.pairs = [(model.active.effect, model.active.site) for model in found]
        return _look(one.size, one.data, one.base, (one.models[0], *found))


def _look(size: float, data: Data, base: Fit, models: tuple[CandidateModel, ...]) -> Look:
    return Look(size, data, base, models, contest(data, base, list(models)))


def _form(setting: Setting, effect: str, site: Site, rng: np.random.Generator, rivals: _Rivals) -> Form | None:
    """Draw a form of the fault on an arm as it might be built, and look at it about the size at which it is found."""
    bench, scene = setting.bench(rng, effect)
    hidden = draw_at(rng, scene, Wanted(effect, _EVENT_PX[0], site))
    seed = int(rng.integers(2**32))
    alone: dict[float, Look | None] = {}

    def look(size: float) -> Look | None:
        if size not in alone:
            data, base = base_fit(data_without_noise(scene, hide(bench, effect, hidden, size)))
            own = own_models(data, base, effect, site)
            alone[size] = _look(size, data, base, (own[0],)) if own else None
        return alone[size]

    def is_found(one: Look | None) -> bool:
        if one is None:
            return False
        return answers(one.contest, 1.0, np.random.default_rng(seed), _FEW_DRAWS).found >= _SHARES[1]

    first = look(hidden.start)
    if first is None:
        return None
    if is_event(hidden):
        return Form((rivals.beside(first),))
    explained = float(first.contest.distance[0] - first.contest.distance[1])
    aim = _AIM + float(first.contest.complexity[0]) + _AIM_SPREADS * np.sqrt(2.0 * first.contest.values)
    size = min(hidden.start * float(np.clip(np.sqrt(aim / max(explained, 1e-9)), 0.003, 30.0)), hidden.most)
    for _ in range(_STEPS):  # down to where it is no longer found, without rivals
        if not is_found(look(size)):
            break
        size /= _NEAR
    looks: list[Look] = []
    for _ in range(2 * _STEPS):  # and up to where it is, with them
        one = look(size)
        if one is not None and (rivals.pairs is not None or is_found(one)):
            one = rivals.beside(one)
        looks += [] if one is None else [one]
        if size >= hidden.most or (rivals.pairs is not None and is_found(one)):
            break
        size = min(size * _NEAR, hidden.most)
    return Form(tuple(looks)) if looks else None


def _summed(effect: str, site: Site, unit: str, forms: list[Form], most: float, rng: np.random.Generator) -> PlacePower:
    simulated = [look.size for form in forms for look in form.looks]
    sizes = np.geomspace(min(simulated) / _NEAR**2, min(max(simulated) * _NEAR, most), _SIZES)
    seed = int(rng.integers(2**32))
    told = [[form.at(float(size), seed) for form in forms] for size in sizes]
    found = np.array([np.mean([one.found for one in row]) for row in told])
    size_50, size_90 = (crossing(sizes, found, share) for share in _SHARES)
    about = size_90 or float(sizes[-1])
    said: Counter[str] = Counter()
    for form in forms:
        said.update(form.at(0.5 * about, seed).said)
    total = sum(said.values())
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
        taken_for={name: count / total for name, count in said.most_common()},
        estimates=dict(intervals(look.data, look.models[0])),
        moves=scale * float(np.sqrt(one.distance[0] / one.values)),
        rivals=rivals,
    )


def _of_one_size(effect: str, site: Site, forms: list[Form], rng: np.random.Generator) -> PlacePower:
    told = [answers(form.looks[0].contest, 1.0, rng) for form in forms]
    said = sum((one.said for one in told), Counter[str]())
    shares = [one.found for one in told]
    return PlacePower(
        effect=effect,
        site=site,
        unit="",
        sizes=(1.0,),
        found=(float(np.mean(shares)),),
        low=(min(shares),),
        high=(max(shares),),
        taken_for={name: count / sum(said.values()) for name, count in said.most_common()},
        fixed=True,
    )


def _of_events(
    setting: Setting, effect: str, site: Site, unit: str, rng: np.random.Generator, fixed: bool
) -> PlacePower:
    """Return the same for what is found sample by sample: the diagnosis' own finders on draws of the noise."""
    sizes = np.ones(1) if fixed else np.geomspace(*_EVENT_PX, _EVENT_SIZES)
    told = [event_answers(setting, effect, site, float(size), rng) for size in sizes]
    bands = [wilson(one.said[effect], sum(one.said.values())) for one in told]
    found = np.array([one.found for one in told])
    size_50, size_90 = (None if fixed else crossing(sizes, found, share) for share in _SHARES)
    below = max((k for k, size in enumerate(sizes) if size < (size_90 or np.inf)), default=0)
    total = sum(told[below].said.values())
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
        taken_for={name: count / total for name, count in told[below].said.most_common()},
        fixed=fixed,
    )


def crossing(sizes: Array, found: Array, share: float) -> float | None:
    """Return the size at which a rising curve reaches a share, between two sizes by their logarithms."""
    above = np.flatnonzero(found >= share)
    if not len(above):
        return None
    k = int(above[0])
    if k == 0:
        return float(sizes[0])
    part = (share - found[k - 1]) / (found[k] - found[k - 1])
    return float(np.exp((1 - part) * np.log(sizes[k - 1]) + part * np.log(sizes[k])))


def _spawn(effect: str, site: Site) -> tuple[int, ...]:
    """Return a key of random numbers that belongs to one effect and place."""
    return tuple(f"{effect} {site}".encode())
