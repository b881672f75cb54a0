"""Which worlds a sealed set holds: nothing hidden, one effect, two, or one that no catalogue has."""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Callable, Mapping, Sequence
from itertools import combinations, cycle, islice
from pathlib import Path
from types import ModuleType
from typing import Annotated, Literal

import numpy as np
from numpy.random import Generator
from pydantic import Field

from armtwin.models.catalogue.registry import catalogue
from armtwin.models.errors import InputError, nearest, shown
from armtwin.models.validation import FROM_LIST, Strict
from armtwin.sim.sealed import STRENGTHS, Sealed, Strength, sealed_effects

Kind = Literal["null", "single", "pair", "quad", "uncatalogued"]

# Shares of a mixed set.
_NULL_SHARE = 0.1
_PAIR_SHARE = 0.2
_UNCATALOGUED_SHARE = 0.15


class SealOptions(Strict):
    """What a sealed set was asked for; the same options give the same set."""

    n: Annotated[int, Field(ge=1, le=9999)]
    seed: Annotated[int, Field(ge=0, lt=2**63)]
    frames: bool = False
    effects: Annotated[tuple[str, ...], FROM_LIST] = ()
    pairs: bool = False
    uncatalogued: str | None = None
    moving: bool = False


class Order(Strict):
    """One world to be made; `effects` are names of the catalogue, or one of the uncatalogued."""

    kind: Kind
    effects: Annotated[tuple[str, ...], FROM_LIST] = ()
    strength: Strength = "medium"


def orders(options: SealOptions) -> list[Order]:
    """List the worlds of a set, in the random order in which they are numbered; raises `InputError`."""
    rng = np.random.default_rng(np.random.SeedSequence(options.seed, spawn_key=(0,)))
    known = sealed_effects()
    singles = [name for name in options.effects if name != "none"] or list(known)
    for name in singles:
        if name not in known:
            raise InputError(f"--effects: unknown effect '{shown(name)}'{nearest(name, known)}; 'none' hides nothing")
    only = set(options.effects) == {"none"}
    counts: dict[Kind, int] = {
        "null": _nulls(options, only),
        "pair": round(_PAIR_SHARE * options.n) if options.pairs and not only else 0,
        "uncatalogued": round(_UNCATALOGUED_SHARE * options.n) if options.uncatalogued else 0,
    }
    counts["single"] = max(options.n - sum(counts.values()), 0)
    strange = list(load_uncatalogued(Path(options.uncatalogued)).names) if options.uncatalogued else []
    made = [Order(kind="null")] * counts["null"]
    made += _strengths("single", [(name,) for name in islice(cycle(rng.permutation(singles)), counts["single"])])
    made += _strengths("pair", _pairs(rng, singles, counts["pair"]))
    made += _strengths("uncatalogued", [(name,) for name in islice(cycle(strange), counts["uncatalogued"])])
    return [made[k] for k in rng.permutation(len(made))]


def _nulls(options: SealOptions, only: bool) -> int:
    if only:
        return options.n
    if options.effects:
        return options.n // len(options.effects) if "none" in options.effects else 0
    return max(1, round(_NULL_SHARE * options.n)) if options.n > 1 else 0


def _strengths(kind: Kind, effects: Sequence[tuple[str, ...]]) -> list[Order]:
    """Let the strengths change with every round through the effects, so that each effect meets each strength."""
    rounds: dict[tuple[str, ...], int] = {}
    levels = list(STRENGTHS)
    made = []
    for k, names in enumerate(effects):
        turn = rounds.get(names, k % len(levels))
        rounds[names] = turn + 1
        made.append(Order(kind=kind, effects=tuple(map(str, names)), strength=levels[turn % len(levels)]))
    return made


def _pairs(rng: Generator, names: Sequence[str], count: int) -> list[tuple[str, ...]]:
    """Pairs of effects that the catalogue does not call confusable: of two that are, one may stand for both.

    What the geometry takes up altogether can be no part of a pair that has to be named.
    """
    known = catalogue()
    apart = [
        (a, b)
        for a, b in combinations([name for name in names if known[name].gauge is None], 2)
        if a not in known[b].confused_with and b not in known[a].confused_with
    ]
    if count and not apart:
        raise InputError("--pairs: no two of these effects can be told apart; give more in --effects")
    return list(islice(cycle([apart[k] for k in rng.permutation(len(apart))]), count)) if apart else []


class Uncatalogued:
    """A file's effects that no catalogue has: `UNCATALOGUED`, by name, and `draw_uncatalogued(rng, name, strength)`."""

    def __init__(self, module: ModuleType, path: Path) -> None:
        names = getattr(module, "UNCATALOGUED", None)
        draw = getattr(module, "draw_uncatalogued", None)
        if not isinstance(names, Mapping) or not callable(draw):
            raise InputError(f"{path}: defines no mapping UNCATALOGUED and function draw_uncatalogued")
        self.names: tuple[str, ...] = tuple(map(str, names))
        self.draw: Callable[[Generator, str, Strength], Sealed] = draw


def load_uncatalogued(path: Path) -> Uncatalogued:
    """Load a Python file of uncatalogued effects. The file is run: load only what you trust."""
    spec = importlib.util.spec_from_file_location(f"armtwin_uncatalogued_{path.stem}", path)
    if not path.is_file() or spec is None or spec.loader is None:
        raise InputError(f"--uncatalogued: no Python file '{path}'")
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # its dataclasses look themselves up there
    try:
        spec.loader.exec_module(module)
    except (Exception, SystemExit) as error:  # somebody else's program: whatever it raises is its fault
        raise InputError(f"--uncatalogued: '{path}' does not run: {type(error).__name__}: {error}") from error
    return Uncatalogued(module, path)
