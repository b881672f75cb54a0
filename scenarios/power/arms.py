"""The arms that a plan might be run on: drawn once, and what is worked out of one is kept for all faults put in it."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from armtwin.models.world import World
from armtwin.scenarios.power.contest import base_fit
from armtwin.scenarios.power.setting import Setting, data_without_noise
from armtwin.scenarios.power.signatures import Signatures
from armtwin.sim.sealed import Scene
from armtwin.sim.sealed.draw import sealing_of

# In gravity or as drawn, with times or as drawn.
Kind = tuple[bool, bool]


@dataclass(frozen=True, eq=False)
class Arms:
    """Arms as they might have been built, in a setting; `number` is the same for all faults that ask the same of it."""

    setting: Setting
    seed: int
    _benches: dict[tuple[int, Kind], tuple[World, Scene]] = field(default_factory=dict, repr=False)
    _signatures: dict[Kind, Signatures] = field(default_factory=dict, repr=False)

    def bench(self, number: int, effect: str) -> tuple[World, Scene]:
        """Return an arm without faults and what is done on it, fit for an effect."""
        key = number, _kind(effect)
        if key not in self._benches:
            rng = np.random.default_rng(np.random.SeedSequence(self.seed, spawn_key=(number,)))
            self._benches[key] = self.setting.bench(rng, effect)
        return self._benches[key]

    def signatures(self, effect: str) -> Signatures:
        """Return what every effect would move on the first arm that is fit for `effect`."""
        kind = _kind(effect)
        if kind not in self._signatures:
            bench, scene = self.bench(0, effect)
            self._signatures[kind] = Signatures(*base_fit(data_without_noise(scene, bench)))
        return self._signatures[kind]


def _kind(effect: str) -> Kind:
    how = sealing_of(effect)
    return how.in_gravity, how.timed
