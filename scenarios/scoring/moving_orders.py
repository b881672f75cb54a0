"""Which logs a sealed set of moving arms holds: nothing hidden, one effect, two, four, or what no catalogue has."""

from __future__ import annotations

from itertools import combinations, cycle, islice

import numpy as np

from armtwin.models.catalogue.motion_effect import motion_catalogue
from armtwin.models.errors import InputError, nearest, shown
from armtwin.scenarios.scoring.orders import Kind, Order, SealOptions
from armtwin.sim.sealed_motion.forms import FORMS
from armtwin.sim.sealed_motion.strange import STRANGE

# Shares of a mixed set: of 240 logs 40 hold nothing, 36 two effects, 24 four, and 40 what no catalogue has.
_SHARES: dict[Kind, float] = {"null": 1 / 6, "pair": 0.15, "quad": 0.1, "uncatalogued": 1 / 6}


def moving_orders(options: SealOptions) -> list[Order]:
    """List the logs of a set, in the random order in which they are numbered; raises `InputError`."""
    rng = np.random.default_rng(np.random.SeedSequence(options.seed, spawn_key=(0,)))
    asked = [name for name in options.effects if name != "none"]
    for name in asked:
        if name not in FORMS:
            raise InputError(
                f"--effects: no effect '{shown(name)}' of a moving arm is hidden{nearest(name, FORMS)}; "
                "'none' hides nothing"
            )
    if options.effects:  # so many of each
        singles = [(name,) if name != "none" else () for name in options.effects]
        made = [
            Order(kind="single" if effects else "null", effects=effects)
            for effects in islice(cycle(singles), options.n)
        ]
    else:
        counts = {kind: round(share * options.n) for kind, share in _SHARES.items()}
        names = [str(name) for name in rng.permutation(list(FORMS))]
        made = [Order(kind="null")] * counts["null"]
        made += [Order(kind="pair", effects=pair) for pair in _pairs(rng, names, counts["pair"])]
        made += [Order(kind="quad", effects=_four(rng, names)) for _ in range(counts["quad"])]
        strange = [str(name) for name in rng.permutation(list(STRANGE))]
        made += [Order(kind="uncatalogued", effects=(name,)) for name in islice(cycle(strange), counts["uncatalogued"])]
        left = max(options.n - len(made), 0)
        made += [Order(kind="single", effects=(name,)) for name in islice(cycle(names), left)]
    return [made[k] for k in rng.permutation(len(made))][: options.n]


def _pairs(rng: np.random.Generator, names: list[str], count: int) -> list[tuple[str, ...]]:
    """Pairs of effects that are not confused with one another."""
    apart = [pair for pair in combinations(names, 2) if not _confused(*pair)]
    return list(islice(cycle([apart[k] for k in rng.permutation(len(apart))]), count))


def _four(rng: np.random.Generator, names: list[str]) -> tuple[str, ...]:
    return tuple(str(name) for name in rng.choice(names, size=4, replace=False))


def _confused(one: str, other: str) -> bool:
    known = motion_catalogue()
    return one in known[other].confused_with or other in known[one].confused_with
