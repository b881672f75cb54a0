"""What an effect's injector takes, as files state it: checked and completed before anything is built."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal, Protocol

import numpy as np

from armtwin.models.catalogue.site import NOWHERE, Site
from armtwin.models.errors import InputError, nearest, shown
from armtwin.models.validation import short

Kind = Literal["number", "whole", "sample", "samples", "marker"]
Where = Literal["joint", "link", "marker", "arm", "camera"]

# No recording has more poses than its CSV may hold bytes; a list of samples is far shorter.
_MOST_SAMPLES = 1_000_000
_EACH_JOINT = "{joint}"


class Jointed(Protocol):
    """What is known of the arm that an effect is made in: its joints and its markers."""

    @property
    def n_joints(self) -> int:
        """Number of joints."""

    @property
    def known_markers(self) -> tuple[str, ...]:
        """Names of its markers."""


@dataclass(frozen=True)
class Injected:
    """A parameter of an injector.

    Attributes:
        name: with its unit, as it stands in every file; "{joint}" in it stands for the number of each joint.
        bounds: what is physically possible, of a number or a whole one.
        default: what is taken where it is not given; None: it has to be given, unless `optional`.
        optional: where it is not given the injector takes what suits the world.
        kind: a number, a whole one, a sample's number, a list of such numbers, or a marker's name.
        period: of a number that comes back to itself, as an angle does: values so far apart are one.

    """

    name: str
    bounds: tuple[float, float] = (0.0, 0.0)
    default: float | None = None
    optional: bool = False
    kind: Kind = "number"
    period: float | None = None

    @property
    def required(self) -> bool:
        """Whether it has to be given."""
        return self.default is None and not self.optional


def switch(name: str, default: int) -> Injected:
    """Declare a parameter that is 0 or 1."""
    return Injected(name, (0.0, 1.0), float(default), kind="whole")


def sample(name: str, default: int | None = None) -> Injected:
    """Declare the number of the sample at which something happens."""
    return Injected(name, default=default, kind="sample")


def samples(name: str) -> Injected:
    """Declare a list of samples at which something happens."""
    return Injected(name, kind="samples")


def other_marker(name: str) -> Injected:
    """Declare the name of a marker, beside the one that the effect sits at."""
    return Injected(name, kind="marker")


def taken_by(injected: Sequence[Injected], arm: Jointed) -> dict[str, Injected]:
    """Return the parameters by name, those of each joint written out for this arm."""
    numbers = range(1, arm.n_joints + 1)
    return {
        name: replace(one, name=name)
        for one in injected
        for name in dict.fromkeys(one.name.replace(_EACH_JOINT, str(number)) for number in numbers)
    }


def declared(injected: Sequence[Injected], name: str) -> Injected | None:
    """Return the parameter of this name, of whichever joint, or None."""
    return next((one for one in injected if re.fullmatch(one.name.replace(_EACH_JOINT, r"\d+"), name)), None)


@dataclass(frozen=True)
class Stated:
    """What a file states of an effect; messages begin with `at`, and parameters' keys are named after `inside`."""

    parameters: Mapping[str, Any]
    site: Site = NOWHERE
    at: str = ""
    inside: str = ""


def checked(
    effect: str, where: Where, injected: Sequence[Injected], stated: Stated, arm: Jointed, n_poses: int | None = None
) -> dict[str, Any]:
    """Return the parameters with those defaults that are not stated.

    Raises `InputError` for a site that the arm does not have or the effect does not sit at, a parameter that is
    unknown, missing or beyond what is possible, and a sample beyond the `n_poses` of a recording (None: not known).
    """
    known, at, inside = taken_by(injected, arm), stated.at, stated.inside
    for name in stated.parameters:
        if name not in known:
            raise InputError(f"{at}unknown key '{inside}{shown(name)}'{nearest(name, [*known, *_site_keys(where)])}")
    _check_site(effect, where, stated, arm)
    for name, one in known.items():
        if one.required and name not in stated.parameters:
            raise InputError(f"{at}key '{inside}{name}' is missing: {_wanted(one, arm, n_poses)} is wanted")
    if known and not stated.parameters:
        raise InputError(f"{at}{effect} gets none of its parameters {', '.join(known)}")
    for name, value in stated.parameters.items():
        if not _is_possible(known[name], value, arm, n_poses):
            wanted = _wanted(known[name], arm, n_poses)
            raise InputError(f"{at}{inside}{name}: found {short(value)}, {wanted} is wanted")
    defaults = {name: one.default for name, one in known.items() if one.default is not None}
    return defaults | dict(stated.parameters)


def shifted_samples(
    injected: Sequence[Injected], parameters: Mapping[str, Any], arm: Jointed, samples_before: int
) -> dict[str, Any]:
    """Return the parameters for a recording that begins after `samples_before` poses: what came before has happened."""
    kinds = {name: one.kind for name, one in taken_by(injected, arm).items()}
    shifted = dict(parameters)
    for name, value in parameters.items():
        if kinds.get(name) == "sample":
            shifted[name] = max(0, int(value) - samples_before)
        elif kinds.get(name) == "samples":
            shifted[name] = [int(row) - samples_before for row in value if row >= samples_before]
    return shifted


def _site_keys(where: Where) -> tuple[str, ...]:
    return ("joint",) if where in ("joint", "link") else ("marker",) if where == "marker" else ()


def _check_site(effect: str, where: Where, stated: Stated, arm: Jointed) -> None:
    wanted = {"joint": f"a number from 1 to {arm.n_joints}", "marker": f"one of {', '.join(arm.known_markers)}"}
    number = _whole(stated.site.joint)
    possible = {
        "joint": number is not None and 1 <= number <= arm.n_joints,
        "marker": stated.site.marker in arm.known_markers,
    }
    for key, value in (("joint", stated.site.joint), ("marker", stated.site.marker)):
        if key not in _site_keys(where):
            if value is not None:
                raise InputError(f"{stated.at}{key}: found {short(value)}, {effect} sits at no {key}: remove this key")
        elif value is None:
            raise InputError(f"{stated.at}key '{key}' is missing: {effect} sits at a {where}, {wanted[key]} is wanted")
        elif not possible[key]:
            raise InputError(f"{stated.at}{key}: found {short(value)}, {wanted[key]} is wanted")


def _is_possible(one: Injected, value: object, arm: Jointed, n_poses: int | None) -> bool:
    if one.kind == "marker":
        return value in arm.known_markers
    if one.kind == "samples":
        rows = value if isinstance(value, list | tuple) and len(value) <= _MOST_SAMPLES else [None]
        return all(_is_sample(row, n_poses) for row in rows)
    if one.kind == "sample":
        return _is_sample(value, n_poses)
    number = _whole(value) if one.kind == "whole" else _number(value)
    return number is not None and one.bounds[0] <= number <= one.bounds[1]


def _is_sample(value: object, n_poses: int | None) -> bool:
    row = _whole(value)
    return row is not None and 0 <= row < (_MOST_SAMPLES if n_poses is None else n_poses)


def _number(value: object) -> float | None:
    if isinstance(value, bool) or not isinstance(value, int | float | np.integer):
        return None
    try:
        return float(value)
    except OverflowError:  # a whole number of hundreds of digits
        return None


def _whole(value: object) -> int | None:
    """Return a whole number, written with a decimal point or without; None for anything else."""
    number = _number(value)
    return int(number) if number is not None and number.is_integer() else None


def _wanted(one: Injected, arm: Jointed, n_poses: int | None) -> str:
    if one.kind == "marker":
        return f"one of the markers {', '.join(arm.known_markers)}"
    if one.kind in ("sample", "samples"):
        what = "a sample's number" if one.kind == "sample" else "a list of samples' numbers"
        return f"{what} from 0" + (f" to {n_poses - 1}" if n_poses else "")
    low, high = one.bounds
    return f"a {'whole ' if one.kind == 'whole' else ''}number from {low:g} to {high:g}"
