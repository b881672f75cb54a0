"""SWEEP.toml (`armtwin.sweep/1`): the factors that are crossed or drawn, and how many worlds are spent on them."""

from __future__ import annotations

from itertools import product
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, model_validator

from armtwin.models.arm import nominal_arm
from armtwin.models.catalogue.site import NOWHERE, Site
from armtwin.models.errors import InputError, nearest
from armtwin.models.toml_reader import read_toml
from armtwin.models.validation import FROM_LIST, Positive, Strict, check
from armtwin.sim.sealed import sealed_effects

NONE = "none"
DRAWN = "drawn"
ALL = "all"
_PLUS = "+"

Names = Annotated[tuple[str, ...], FROM_LIST, Field(min_length=1)]
Poses = Annotated[int, Field(ge=12, le=5000)]


class Factors(Strict):
    """What is varied; every list is crossed with all others.

    Attributes:
        effects: names, pairs as `backlash + gravity_sag`, `none`, or `all`.
        places: `any`, `whole`, `joint 2`, `marker b`.
        sizes: in the effect's own unit, of pairs in multiples of what each starts at; empty: placed where the answer
            changes.
        noise_px: of one pixel coordinate.
        poses: how many of the plan's.
        plans: `drawn` (anew for every world), `paper`, or a CSV beside the sweep's file.
        markers: the markers looked for, as letters.
        noise_declared: whether the recording states its noise.
        rendered: whether markers are measured in rendered pictures.
        motion: `settled`.

    """

    effects: Names = (ALL,)
    places: Names = ("any",)
    sizes: Annotated[tuple[Positive, ...], FROM_LIST] = ()
    noise_px: Annotated[tuple[Positive, ...], FROM_LIST, Field(min_length=1)] = (0.06,)
    poses: Annotated[tuple[Poses, ...], FROM_LIST, Field(min_length=1)] = (100,)
    plans: Names = (DRAWN,)
    markers: Names = ("abcf",)
    noise_declared: Annotated[tuple[bool, ...], FROM_LIST, Field(min_length=1)] = (True,)
    rendered: Annotated[tuple[bool, ...], FROM_LIST, Field(min_length=1)] = (False,)
    motion: Names = ("settled",)


class SweepTable(Strict):
    """A sweep's file.

    Attributes:
        seed: every world's own follows from it, the number of its cell and its own.
        trials: worlds a cell at most (and a size, where sizes are given).
        confirm: further worlds at the size that was found, which did not place it.
        draw: so many cells at random from the crossing, where it is larger than can be paid.

    """

    schema_: Literal["armtwin.sweep/1"] = Field(alias="schema")
    seed: Annotated[int, Field(ge=0, lt=2**63)] = 0
    trials: Annotated[int, Field(ge=1, le=100_000)] = 40
    confirm: Annotated[int, Field(ge=0, le=10_000)] = 0
    draw: Annotated[int, Field(ge=1)] | None = None
    factors: Factors = Factors()

    @model_validator(mode="after")
    def _is_of_today(self) -> SweepTable:
        for motion in self.factors.motion:
            if motion != "settled":
                raise ValueError(f"factors.motion: found '{motion}'; only 'settled' worlds can be swept: leave it out")
        return self


class Cell(Strict):
    """One combination of factors. `number` counts the whole crossing from 0, so that it stays where cells are drawn."""

    number: int
    effects: tuple[str, ...]
    place: str
    size: float | None
    noise_px: float
    poses: int
    plan: str
    markers: str
    noise_declared: bool
    rendered: bool

    @property
    def effect(self) -> str:
        """The effects' names as they are written."""
        return f" {_PLUS} ".join(self.effects) or NONE

    @property
    def is_pair(self) -> bool:
        """Whether several effects are hidden: their sizes are then multiples of what each starts at when drawn."""
        return len(self.effects) > 1


def read_sweep(path: Path) -> SweepTable:
    """Read a sweep's file; raises `InputError` with the key and what was wanted there."""
    table = check(SweepTable, read_toml(path), str(path))
    known = sealed_effects()
    for entry in table.factors.effects:
        for name in _names(entry):
            if name not in known:
                raise InputError(f"{path}: factors.effects: unknown effect '{name}'{nearest(name, (*known, ALL))}")
    for place in table.factors.places:
        place_of(place, str(path))
    arm = nominal_arm()
    for markers in table.factors.markers:
        if len(markers) < 2 or set(markers) - set(arm.marker_names) or len(set(markers)) < len(markers):
            names = "".join(arm.marker_names)
            raise InputError(f"{path}: factors.markers: found '{markers}', at least two letters of {names} are wanted")
    return table


def cells_of(table: SweepTable) -> list[Cell]:
    """List the cells of a sweep, in order of their numbers."""
    f = table.factors
    effects = [name for entry in f.effects for name in (sealed_effects() if entry == ALL else (entry,))]
    sizes: tuple[float | None, ...] = f.sizes or (None,)
    crossed = product(effects, f.places, sizes, f.noise_px, f.poses, f.plans, f.markers, f.noise_declared, f.rendered)
    cells = [
        Cell(
            number=number,
            effects=_names(effect),
            place=place,
            size=size,
            noise_px=noise,
            poses=poses,
            plan=plan,
            markers=markers,
            noise_declared=declared,
            rendered=rendered,
        )
        for number, (effect, place, size, noise, poses, plan, markers, declared, rendered) in enumerate(crossed)
    ]
    if table.draw is None or table.draw >= len(cells):
        return cells
    rng = np.random.default_rng(np.random.SeedSequence(table.seed, spawn_key=(0,)))
    return [cells[k] for k in sorted(rng.choice(len(cells), table.draw, replace=False))]


def place_of(text: str, file: str = "SWEEP.toml") -> Site | None:
    """Return the place that a text names, None for any; raises `InputError`."""
    kind, _, what = text.partition(" ")
    if text == "any":
        return None
    if text == "whole":
        return NOWHERE
    if kind == "joint" and what.isascii() and what.isdecimal():
        return Site(joint=int(what))
    if kind == "marker" and what in nominal_arm().marker_names:
        return Site(marker=what)
    raise InputError(f"{file}: factors.places: found '{text}'; any, whole, joint 2 or marker b is wanted")


def _names(entry: str) -> tuple[str, ...]:
    return () if entry in (NONE, ALL) else tuple(name.strip() for name in entry.split(_PLUS))
