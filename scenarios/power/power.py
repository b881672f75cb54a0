"""The whole of a plan's power: every effect at every place, over a few processes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any
from uuid import uuid4

import numpy as np

from armtwin.calib.diagnosis.ties import SMALL_SHARE
from armtwin.models.catalogue.site import Site
from armtwin.scenarios.power.arms import Arms
from armtwin.scenarios.power.form import crossing
from armtwin.scenarios.power.place import PlacePower, power_at
from armtwin.scenarios.power.setting import Setting
from armtwin.scenarios.power.words import label
from armtwin.scenarios.scoring.pool import in_processes
from armtwin.sim.sealed import Wanted, sealed_effects
from armtwin.sim.sealed.of_size import draw_at

SCHEMA = "armtwin.power/1"
FORMS = 3
# Draws after which every place where an effect is hidden has come up.
_PLACE_DRAWS = 60
# The arms of the run that this process works for.
_ARMS: dict[str, Arms] = {}


@dataclass(frozen=True)
class Task:
    """One effect, at all its places; a process keeps what it works out of the setting for all tasks of one `run`."""

    run: str
    setting: Setting
    effect: str
    seed: int
    forms: int


@dataclass(frozen=True)
class Power:
    """What a plan can see, by effect and place, in the catalogue's order."""

    setting: Setting
    places: tuple[PlacePower, ...]

    def of(self, effect: str) -> tuple[PlacePower, ...]:
        """Return the places of one effect."""
        return tuple(one for one in self.places if one.effect == effect)

    @property
    def inseparable(self) -> tuple[tuple[PlacePower, str], ...]:
        """Pairs that no size of the fault tells apart: what does is too small a share of what either explains."""
        return tuple(
            (one, label(key[0], Site(*key[1:])))
            for one in self.places
            for key, share, _ in one.rivals
            if share < SMALL_SHARE
        )


def power(
    setting: Setting,
    *,
    effects: Sequence[str] = (),
    seed: int = 0,
    forms: int = FORMS,
    jobs: int = 2,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> Power:
    """Work out what a plan can see of `effects`, by default of all; the same seed gives the same answer."""
    run = uuid4().hex
    tasks = [(name, Task(run, setting, name, seed, forms)) for name in effects or sealed_effects()]
    done: dict[str, list[PlacePower]] = {}
    progress(0, len(tasks))
    for name, answer in in_processes(run_task, tasks, min(jobs, len(tasks))):
        if isinstance(answer, BaseException):
            raise answer
        done[name] = answer
        progress(len(done), len(tasks))
    return Power(setting, tuple(place for name, _ in tasks for place in done[name]))


def run_task(task: Task) -> list[PlacePower]:
    """Work out one effect at its places; where it was found at one is where it is looked at first at the next."""
    if task.run not in _ARMS:
        _ARMS.clear()
        _ARMS[task.run] = Arms(task.setting, task.seed)
    arms, told = _ARMS[task.run], list[PlacePower]()
    for site in places_of(arms, task.effect):
        near = told[-1].size_90 if told else None
        told.append(power_at(arms, task.effect, site, task.forms, near))
    return told


def places_of(arms: Arms, effect: str) -> list[Site]:
    """List the places at which an effect is hidden on the setting's arm, in order."""
    rng = np.random.default_rng(0)
    _, scene = arms.bench(0, effect)
    drawn = {draw_at(rng, scene, Wanted(effect, 1.0)).site for _ in range(_PLACE_DRAWS)}
    return sorted(drawn, key=lambda site: (site.joint or 0, site.marker or ""))


def over_places(places: Sequence[PlacePower], share: float) -> float | None:
    """Return the size found in a share of the recordings where each place is as likely as another."""
    seen = [one for one in places if one.sizes and not one.fixed]
    if not seen or any(one.why_not for one in places):
        return None
    sizes = np.geomspace(min(one.sizes[0] for one in seen), max(one.sizes[-1] for one in seen), 60)
    found = np.mean([np.interp(np.log(sizes), np.log(one.sizes), one.found) for one in seen], axis=0)
    return crossing(sizes, found, share)


def power_table(result: Power) -> dict[str, Any]:
    """Return the content of `power.json`."""
    setting = result.setting
    return {
        "schema": SCHEMA,
        "poses": len(setting.plan),
        "noise_px": setting.noise_px,
        "markers": list(setting.markers),
        "places": [_place_table(one) for one in result.places],
        "inseparable": [[label(one.effect, one.site), rival] for one, rival in result.inseparable],
    }


def _place_table(one: PlacePower) -> dict[str, Any]:
    return {
        "effect": one.effect,
        "joint": one.site.joint,
        "marker": one.site.marker,
        "unit": one.unit,
        "found_as_it_is": one.share if one.fixed else None,
        "size_50": one.size_50,
        "size_90": one.size_90,
        "why_not": one.why_not or None,
        "moves_noises": one.moves,
        "estimates": {name: {"value": value, "std": std} for name, (value, std) in one.estimates.items()},
        "taken_for_at_half": one.taken_for,
        "rivals": [
            {"rival": label(key[0], Site(*key[1:])), "share_apart": share, "deviance_apart": apart}
            for key, share, apart in one.rivals
        ],
        "curve": {"size": one.sizes, "found": one.found, "low": one.low, "high": one.high},
    }
