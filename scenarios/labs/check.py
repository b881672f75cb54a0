"""A check of a student's answer: open, wrong with what is wrong with it, or right.

    @check("The inverse closes the loop")
    def closes_the_loop(answer):
        ...
        require(miss < 1e-9, f"FK(IK(p)) misses p by up to {miss:.3g} mm")

The judge is given the student's function or value. It says nothing where the answer is right, `require`s otherwise, and
whatever the student's own code raises is told as that. An answer that is still None is open: nothing is wrong yet.
"""

from __future__ import annotations

import functools
import html
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
State = Literal["open", "wrong", "right"]

_MARKS = {"open": ("○", "#8a8a8a", "open"), "wrong": ("✗", "#d55e00", "not yet"), "right": ("✓", "#009e73", "right")}
_FILENAME = __file__


class WrongAnswerError(Exception):
    """What is wrong with an answer, for the student."""


class OpenAnswerError(Exception):
    """Nothing was answered yet."""


@dataclass(frozen=True)
class Check:
    """How an answer was found: `said` tells the student what is wrong, or what his answer achieves."""

    question: str
    state: State
    said: str

    @property
    def passed(self) -> bool:
        """Whether the answer is right."""
        return self.state == "right"

    def _mime_(self) -> tuple[str, str]:
        """Show it in the notebook; the state is a word as well as a colour."""
        mark, colour, word = _MARKS[self.state]
        return "text/html", (
            f'<div role="status" style="border-left: 4px solid {colour}; padding: 0.3rem 0.8rem; margin: 0.3rem 0">'
            f'<strong style="color: {colour}">{mark} {word}</strong> {html.escape(self.question)}'
            f'<div style="opacity: 0.85">{html.escape(self.said)}</div></div>'
        )


def check(question: str) -> Callable[[Callable[..., str | None]], Callable[..., Check]]:
    """Make a check of a judge, a function of the student's answers that may return what a right one achieves."""

    def of(judge: Callable[..., str | None]) -> Callable[..., Check]:
        @functools.wraps(judge)
        def checked(*answers: Any) -> Check:
            if any(answer is None for answer in answers):
                return Check(question, "open", "Nothing here yet: fill in the cell above.")
            try:
                with np.errstate(all="ignore"):
                    said = judge(*answers)
            except OpenAnswerError:
                return Check(question, "open", "Your function returns None: write what it is to do.")
            except WrongAnswerError as error:
                return Check(question, "wrong", str(error))
            except Exception as error:  # noqa: BLE001  # the student's own code may raise anything
                return Check(question, "wrong", _told(error))
            return Check(question, "right", said or "")

        return checked

    return of


def require(holds: bool | np.bool_, otherwise: str) -> None:
    """Raise that the answer is wrong, for the reason given, unless `holds`."""
    if not holds:
        raise WrongAnswerError(otherwise)


def array(value: Any, shape: tuple[int, ...], name: str) -> Array:
    """Return a student's value as an array of that shape, of finite numbers; say what it is instead."""
    if value is None:
        raise OpenAnswerError
    wanted = "a number" if shape == () else f"an array of shape {shape}"
    try:
        found = np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        raise WrongAnswerError(f"{name}: {wanted} is wanted, yours is a {type(value).__name__}") from None
    if found.shape != shape:
        raise WrongAnswerError(f"{name}: {wanted} is wanted, yours has shape {found.shape}")
    if not np.isfinite(found).all():
        raise WrongAnswerError(f"{name}: {np.count_nonzero(~np.isfinite(found))} of its values are not finite")
    return found


def number(value: Any, name: str) -> float:
    """Return a student's value as a finite number."""
    return float(array(value, (), name))


def copies(*values: Array) -> list[Array]:
    """Return copies, so that a function that writes into its arguments cannot change what it is held against."""
    return [np.array(value) for value in values]


def _told(error: Exception) -> str:
    """The student's exception, with the line of his own code that it came from."""
    frames = [frame for frame in traceback.extract_tb(error.__traceback__) if frame.filename != _FILENAME]
    own = [frame for frame in frames if "armtwin" not in frame.filename and "site-packages" not in frame.filename]
    where = f" in '{own[-1].line}'" if own and own[-1].line else ""
    return f"Your code stopped with {type(error).__name__}: {error}{where}"
