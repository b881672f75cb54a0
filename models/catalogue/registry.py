"""The catalogue: every effect by name, those of the package and those that a person adds."""

from __future__ import annotations

import importlib
import importlib.util
import pkgutil
from collections.abc import Mapping
from pathlib import Path

from armtwin.models.catalogue.effect import Effect, Parameter, Stage
from armtwin.models.catalogue.evidence import Evidence, View
from armtwin.models.catalogue.found import Found
from armtwin.models.catalogue.guard import guarded
from armtwin.models.catalogue.site import Site
from armtwin.models.errors import InputError, nearest, shown

# What an effect's file needs stands here by one name.
__all__ = [
    "Effect",
    "Evidence",
    "Found",
    "Parameter",
    "Site",
    "Stage",
    "View",
    "catalogue",
    "effect_named",
    "register",
    "register_file",
    "registered_files",
]

_LOADED: dict[str, Effect] = {}
# Files of a person's own, with the names of their effects.
_FILES: dict[Path, str] = {}


def catalogue() -> Mapping[str, Effect]:
    """Return every registered effect by name: one module of this package each, and those added by `register`."""
    if not _LOADED:
        package = importlib.import_module("armtwin.models.effects")
        for module in pkgutil.iter_modules(package.__path__):
            effect = getattr(importlib.import_module(f"armtwin.models.effects.{module.name}"), "EFFECT", None)
            if isinstance(effect, Effect):
                _LOADED[effect.name] = effect
    return _LOADED


def effect_named(name: str) -> Effect:
    """Return an effect; raises `InputError` with the nearest valid name."""
    known = catalogue()
    if name not in known:
        raise InputError(f"unknown effect '{shown(name)}'{nearest(name, known)}")
    return known[name]


def register(effect: Effect) -> None:
    """Add an effect from outside the package; raises `InputError` where the name is taken."""
    if effect.name in catalogue():
        raise InputError(f"effect '{effect.name}' is registered already; choose another name")
    _LOADED[effect.name] = effect


def register_file(path: Path) -> Effect:
    """Load a Python file that defines `EFFECT` and register it. The file is run: load only what you trust.

    Raises `InputError` where there is none, it does not run, or it defines no effect of a new name.
    """
    if not path.is_file():
        raise InputError(f"{path}: no such file; an effect is a Python file that defines EFFECT")
    spec = importlib.util.spec_from_file_location(f"armtwin_effect_{path.stem}", path)
    if spec is None or spec.loader is None:
        raise InputError(f"{path}: not a Python file; an effect is a Python file that defines EFFECT")
    module = importlib.util.module_from_spec(spec)
    try:
        spec.loader.exec_module(module)
    except (Exception, SystemExit) as error:  # somebody else's program: whatever it raises is its fault
        raise InputError(f"{path}: does not run: {type(error).__name__}: {error}") from error
    effect = getattr(module, "EFFECT", None)
    if not isinstance(effect, Effect):
        raise InputError(f"{path}: defines no EFFECT of type armtwin.models.catalogue.registry.Effect")
    effect = guarded(effect, path)
    earlier = _FILES.pop(path.resolve(), None)
    if earlier is not None:  # read once more: what it says now counts
        _LOADED.pop(earlier, None)
    register(effect)
    _FILES[path.resolve()] = effect.name
    return effect


def registered_files() -> tuple[Path, ...]:
    """Return the files whose effects were added: what a spawned process has to be given to know the same effects."""
    return tuple(path for path, name in _FILES.items() if name in catalogue())
