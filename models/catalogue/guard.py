"""A person's own effect, held to its contract: whatever it gets wrong is told with the name of its file.

The effects of the package are held to it by their tests instead, so that a fit pays nothing for it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, ParamSpec, TypeVar

import numpy as np
from numpy.typing import NDArray

from armtwin.models.catalogue.camera_path import CameraPath
from armtwin.models.catalogue.context import Context
from armtwin.models.catalogue.effect import Effect, Parameter, Stage, Term
from armtwin.models.catalogue.evidence import Evidence, Sightings, View
from armtwin.models.catalogue.found import Found
from armtwin.models.catalogue.points import PointState
from armtwin.models.catalogue.site import Site
from armtwin.models.errors import ArmtwinError, InputError

if TYPE_CHECKING:
    from armtwin.models.world import World

Array = NDArray[np.float64]
P = ParamSpec("P")
R = TypeVar("R")
_KINDS = {Stage.POINTS: PointState, Stage.CAMERA: CameraPath}
_NOUNS = dict.fromkeys(Stage, "angles") | {Stage.POINTS: "points", Stage.CAMERA: "camera's motion"}


def guarded(effect: Effect, path: Path) -> Effect:
    """Return the effect of file `path` with each of its functions checked as it is called."""
    place = f"{path}: effect '{effect.name}'"

    def named(function: Callable[P, R], what: str) -> Callable[P, R]:
        def call(*args: P.args, **kwargs: P.kwargs) -> R:
            with _told(place, what):
                return function(*args, **kwargs)

        return call

    return replace(
        effect,
        parameters=partial(_parameters, effect, place),
        term=None if effect.term is None else _guarded_term(effect, place),
        starts=partial(_starts, effect, place),
        screen=None if effect.screen is None else partial(_screen, effect, place),
        applies=named(effect.applies, "applies"),
        physical=None if effect.physical is None else named(effect.physical, "physical"),
        injector=partial(_inject, effect, place),
        found=None if effect.found is None else _guarded_found(effect.found, place),
        sealed=None if effect.sealed is None else replace(effect.sealed, draw=named(effect.sealed.draw, "sealed draw")),
    )


@contextmanager
def _told(place: str, what: str, given: str = "arrays") -> Iterator[None]:
    try:
        yield
    except ArmtwinError:  # what it refuses itself, or another check found
        raise
    except Exception as error:  # somebody else's program: whatever it raises is its fault
        if isinstance(error, ValueError) and "read-only" in str(error):
            why = f"its {what} changes the {given} it is given; begin with a copy of them"
        else:
            why = f"its {what} raises {type(error).__name__}: {error}"
        raise InputError(f"{place}: {why}") from error


def _guarded_term(effect: Effect, place: str) -> Term:
    def term(context: Context, given: Any, values: Array, site: Site) -> Any:  # as the stage has it
        given, values = _frozen(given), _frozen(values)
        with _told(place, "term", _NOUNS[effect.stage]):
            made = effect.term(context, given, values, site)  # type: ignore[misc]
        _check_made(place, "term", effect.stage, given, made)
        return made

    return term


def _check_made(place: str, what: str, stage: Stage, given: Any, made: Any) -> None:
    kind, noun = _KINDS.get(stage, np.ndarray), _NOUNS[stage]
    if not isinstance(made, kind):
        raise InputError(
            f"{place}: its {what} returns {type(made).__name__}; a {kind.__name__} is wanted ({stage.name})"
        )
    for array, shape in _arrays(given, made):
        if shape is not None and np.shape(array) != shape:
            raise InputError(f"{place}: its {what} returns shape {np.shape(array)}, {noun} of shape {shape} are wanted")
        if not np.isfinite(array).all():
            raise InputError(f"{place}: its {what} returns what is not finite, finite {noun} are wanted")


def _arrays(given: Any, made: Any) -> list[tuple[Array, tuple[int, ...] | None]]:
    """What was made, with the shapes that are wanted of it (None: any)."""
    if isinstance(made, PointState):
        return [(made.points_mm, given.points_mm.shape)]
    if isinstance(made, CameraPath):
        return [(value, None) for value in vars(made).values()]
    return [(made, given.shape)]


def _frozen(given: Any) -> Any:
    """The same, with arrays that refuse to be changed."""
    if isinstance(given, np.ndarray):
        view = given.view()
        view.flags.writeable = False
        return view
    changes = {name: _frozen(value) for name, value in vars(given).items() if isinstance(value, np.ndarray)}
    return replace(given, **changes)


def _parameters(effect: Effect, place: str, context: Context, site: Site) -> tuple[Parameter, ...]:
    with _told(place, "parameters"):
        made = tuple(effect.parameters(context, site))
    for one in made:
        if not isinstance(one, Parameter):
            raise InputError(f"{place}: its parameters hold {type(one).__name__}; each is a Parameter")
    return made


def _starts(effect: Effect, place: str, context: Context, site: Site, around: Array | None) -> Iterable[Array]:
    with _told(place, "starts"):
        made = [np.asarray(start, dtype=float) for start in effect.starts(context, site, around)]
    return _checked_starts(effect, place, "starts", context, site, made)


def _screen(effect: Effect, place: str, context: Context, site: Site, evidence: Evidence) -> Iterable[Array]:
    assert effect.screen is not None
    with _told(place, "screen"):
        made = [np.asarray(start, dtype=float) for start in effect.screen(context, site, evidence)]
    return _checked_starts(effect, place, "screen", context, site, made)


def _checked_starts(
    effect: Effect, place: str, what: str, context: Context, site: Site, made: list[Array]
) -> list[Array]:
    count = len(_parameters(effect, place, context, site))
    for start in made:
        if start.shape != (count,) or not np.isfinite(start).all():
            raise InputError(
                f"{place}: its {what} give {start.tolist()}; {count} finite numbers are wanted, one a parameter"
            )
    return made


def _inject(effect: Effect, place: str, world: World, parameters: Mapping[str, Any], site: Site) -> World:
    with _told(place, "injector"):
        made = effect.injector(world, parameters, site)
    if type(made) is not type(world):
        raise InputError(f"{place}: its injector returns {type(made).__name__}; a World is wanted")
    return made


def _guarded_found(found: Found, place: str) -> Found:
    def find(context: Context, view: View) -> list[tuple[Site, Array]]:
        with _told(place, "find"):
            return [(site, np.asarray(values, dtype=float)) for site, values in found.find(context, _frozen(view))]

    def repair(context: Context, seen: Sightings, site: Site, values: Array) -> Sightings:
        assert found.repair is not None
        with _told(place, "repair"):
            made = found.repair(context, _frozen(seen), site, values)
        if made.observed.shape != seen.observed.shape or made.counts.shape != seen.counts.shape:
            raise InputError(f"{place}: its repair changes the shape of the observations")
        return made

    return replace(found, find=find, repair=None if found.repair is None else repair)
