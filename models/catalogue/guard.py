"""An effect of a person's own, watched: what its term gets wrong is told with its file's name, not as our defect."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from armtwin.models.catalogue.registry import Effect
from armtwin.models.errors import ArmtwinError, InputError


def guarded(effect: Effect, path: Path) -> Effect:
    """Return the effect with its term and its starts watched; they raise `InputError` that names `path`.

    A term is told that it raises, changes its input, or returns angles of another shape or that are no numbers.
    """
    place = f"{path.name}: effect '{effect.name}'"
    term = effect.term

    def watched_term(context: Any, state: Any, values: Any, site: Any) -> Any:
        before = state.copy() if isinstance(state, np.ndarray) else None
        given = np.array(values, dtype=float)
        assert term is not None
        out = _called(place, "its term", term, context, state, values, site)
        if before is not None:
            if not np.array_equal(before, state, equal_nan=True):
                raise InputError(f"{place}: its term changes the angles it is given; begin with q = q.copy()")
            _check_angles(place, before, out)
        if not np.array_equal(given, values):
            raise InputError(f"{place}: its term changes the parameter values that it is given; let it copy them")
        return out

    def watched_starts(context: Any, site: Any, around: Any) -> Any:
        return list(_called(place, "its starts", effect.starts, context, site, around))

    return replace(effect, term=None if term is None else watched_term, starts=watched_starts)


def _check_angles(place: str, given: np.ndarray[Any, Any], out: Any) -> None:
    if not isinstance(out, np.ndarray) or out.shape != given.shape:
        found = f"shape {out.shape}" if isinstance(out, np.ndarray) else type(out).__name__
        raise InputError(f"{place}: its term returns {found}, angles of shape {given.shape} are wanted")
    if not np.isfinite(out).all():
        row = int(np.argmin(np.isfinite(out).all(axis=-1)))
        raise InputError(f"{place}: its term returns {out[row]} for row {row}, finite angles are wanted")


def _called(place: str, what: str, function: Callable[..., Any], *arguments: Any) -> Any:
    try:
        return function(*arguments)
    except ArmtwinError:
        raise
    except Exception as error:  # somebody else's program: whatever it raises is its fault
        raise InputError(f"{place}: {what} raises {type(error).__name__}: {error}") from error
