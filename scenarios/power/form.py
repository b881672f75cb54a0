"""A form of a fault on one arm, looked at about the size at which it is found: by proportion from size to size."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armtwin.calib.diagnosis.candidates import CandidateModel
from armtwin.calib.diagnosis.fit import Data, Fit
from armtwin.models.catalogue.sealed import Hidden
from armtwin.models.catalogue.site import Site
from armtwin.models.world import World
from armtwin.scenarios.power.arms import Arms
from armtwin.scenarios.power.contest import Contest, base_fit, contest, least_of_rivals, own_models, rivals_of
from armtwin.scenarios.power.rule import Answers, answers
from armtwin.scenarios.power.setting import data_without_noise
from armtwin.scenarios.power.signatures import Pair
from armtwin.sim.sealed import Scene, hide
from armtwin.sim.sealed.of_size import is_event

Array = NDArray[np.float64]

# Deviance that a cause must explain to be found nine times of ten: its test's level and the noise's own spread.
_AIM, _AIM_SPREADS = 40.0, 1.4
SHARE = 0.9
# Sizes are looked at so often, until what is found at one says that it is found within a factor of it.
_LOOKS, _NEAR = 4, 1.5
# By proportion a look tells of sizes up to this factor.
_REACH, _STEPS = 4.0, 13
_FEW_DRAWS = 100
# So many of the effects and places that promise to come near are fitted.
_FITTED = 8


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
    """A form of a fault on one arm as it might be built, at sizes about that at which it is found.

    It comes as often as its `weight` says among the forms of a fault.
    """

    looks: tuple[Look, ...]
    size_90: float | None
    weight: float

    def at(self, size: float, seed: int) -> Answers:
        """Answers at a size, from the nearest that was simulated; always by the same draws of the noise."""
        near = self.nearest(size)
        return answers(near.contest, size / near.size, np.random.default_rng(seed))

    def nearest(self, size: float) -> Look:
        """Return the look whose size is nearest."""
        return min(self.looks, key=lambda look: abs(np.log(look.size / size)))


@dataclass
class Rivals:
    """The effects and places that come near a fault: looked for once, where it is found."""

    arms: Arms
    effect: str
    pairs: list[Pair] | None = None

    def beside(self, one: Look) -> Look:
        """Return a look with the rivals in it."""
        least = least_of_rivals(one.base, one.models[0])
        pairs = self.pairs
        if pairs is None:
            pairs = self.arms.signatures(self.effect).near(
                one.base.residual, 0.5 * least, _FITTED, one.models[0].active.site
            )
        found = rivals_of(one.data, one.base, one.models[0], pairs)
        if self.pairs is None:
            self.pairs = [(model.active.effect, model.active.site) for model in found]
        return _look(one.size, one.data, one.base, (one.models[0], *found))


@dataclass(frozen=True, eq=False)
class Hiding:
    """An effect drawn in a form, on an arm, and how often such forms come."""

    effect: str
    bench: World
    scene: Scene
    hidden: Hidden
    weight: float

    def at(self, size: float, site: Site) -> Look | None:
        """Simulate it at a size; None where these poses do not show it."""
        data, base = base_fit(data_without_noise(self.scene, hide(self.bench, self.effect, self.hidden, size)))
        own = own_models(data, base, self.effect, site)
        return _look(size, data, base, (own[0],)) if own else None


def _look(size: float, data: Data, base: Fit, models: tuple[CandidateModel, ...]) -> Look:
    return Look(size, data, base, models, contest(data, base, list(models)))


def form_of(hiding: Hiding, site: Site, rivals: Rivals, near: float | None, seed: int) -> Form | None:
    """Look at a form about the size at which it is found, from `near` on if an other form of it was found there."""
    hidden = hiding.hidden
    if is_event(hidden):
        first = hiding.at(hidden.start, site)
        return None if first is None else Form((rivals.beside(first),), None, hiding.weight)
    one = None if near is None else hiding.at(min(near, hidden.most), site)
    if one is None:
        one = _approached(hiding, site, seed)
    if one is None:
        return None
    looks = [rivals.beside(one)]
    for _ in range(_LOOKS):  # rivals only ever make the size larger
        size_90 = _found_from(looks[-1], seed)
        wanted = min(_REACH / 2.0 * looks[-1].size if size_90 is None else size_90, hidden.most)
        if abs(np.log(wanted / looks[-1].size)) < np.log(_NEAR):
            break
        again = hiding.at(wanted, site)
        if again is None:
            break
        looks.append(rivals.beside(again))
    return Form(tuple(looks), size_90, hiding.weight)


def _approached(hiding: Hiding, site: Site, seed: int) -> Look | None:
    """Return the look, without rivals, from which the size found in 90 of 100 is not far."""
    hidden = hiding.hidden
    one = hiding.at(hidden.start, site)
    if one is None:
        return None
    size = min(hidden.start * float(np.clip(_aim(one.contest), 0.003, 30.0)), hidden.most)
    for _ in range(_LOOKS):
        again = hiding.at(size, site)
        if again is None:
            size = min(2.0 * size, hidden.most)
            continue
        one = again
        wanted = min(_found_from(one, seed) or _REACH / 2.0 * size, hidden.most)
        if abs(np.log(wanted / size)) < np.log(_NEAR):
            break
        size = wanted
    return one


def _aim(one: Contest) -> float:
    """Return how many times as large a fault would be found, by what its own model explains."""
    explained = float(one.distance[0] - one.distance[1])
    aim = _AIM + float(one.complexity[0]) + _AIM_SPREADS * np.sqrt(2.0 * one.values)
    return float(np.sqrt(aim / max(explained, 1e-9)))


def _found_from(one: Look, seed: int) -> float | None:
    """Return the size found in 90 of 100 by proportion from a look; None where none is within its reach."""
    sizes = one.size * np.geomspace(1.0 / _REACH, _REACH, _STEPS)
    found = [
        answers(one.contest, float(size) / one.size, np.random.default_rng(seed), _FEW_DRAWS).found for size in sizes
    ]
    return crossing(sizes, np.array(found), SHARE)


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
