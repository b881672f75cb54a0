"""Lab 7: a plan within the budget, and an answer held against a practice robot's truth by a class's own rubric."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from armtwin.models.errors import InputError
from armtwin.scenarios.classes.answer import Answer
from armtwin.scenarios.classes.class_file import Rubric
from armtwin.scenarios.classes.grading import line_errors_mm, shares_of
from armtwin.scenarios.labs.check import WrongAnswerError, check, require
from armtwin.scenarios.labs.material.sealed import BUDGET, PRACTICE, check_poses, measure, practice_robot

Array = NDArray[np.float64]

# A joint that is not turned both ways over so much shows neither play nor a curve, rad.
_TURN_RAD = 0.2
_LINE = 0.9


@check("An experiment within the budget")
def plan(answer: Any, robot: int) -> str:
    """Hold a plan against budget, limits, picture, and what it can show at all."""
    q = _poses(answer)
    for joint in range(3):
        span = float(np.ptp(q[:, joint]))
        require(
            span > _TURN_RAD, f"Joint {joint + 1} turns by {span:.2g} rad in all: what is wrong with it will not show."
        )
        steps = np.sign(np.diff(q[:, joint]))
        require(
            bool((steps > 0).any() and (steps < 0).any()),
            f"Joint {joint + 1} never turns back: play looks like a zero.",
        )
    seen = measure(robot, q)
    lost = sum(int(np.isnan(pixels).any(axis=1).sum()) for pixels in seen.markers_px.values())
    require(lost < len(q), f"In {lost} sightings a marker is outside the picture; stay in it.")
    return f"{len(q)} of {BUDGET} pictures."


@check("The cause and its place")
def cause(answer: Any, robot: int) -> str:
    """Hold a cause against the truth."""
    said = _answer(answer)
    require(said["cause"] in ("none", *PRACTICE), f"One of none, {', '.join(PRACTICE)} is wanted.")
    shares = _shares(said, robot)
    near = "You are near: what you name is easily confused with it. Which experiment tells them apart?"
    require(
        shares["cause"] > 0, "It is something else. What do the residuals follow: the direction, the angle, the load?"
    )
    require(shares["cause"] == 1, near)
    require(shares["place"] == 1, "The cause is right, the place is not.")
    return "Right, and at the right place."


@check("Its size, with an interval that you would bet on 19 to 1")
def size(answer: Any, robot: int) -> str:
    """Hold a size and an interval against the truth."""
    said = _answer(answer)
    require(said["parameter"] is not None and said["value"] is not None, "parameter, value, low and high are wanted.")
    require(said["low"] is not None, "Give the interval too: low and high.")
    shares = _shares(said, robot)
    require(shares["cause"] == 1, "First the cause.")
    require(
        shares["size"] > 0, "Far off, or no parameter of this effect that is at work here: see armtwin effects NAME."
    )
    require(shares["size"] == 1, "Not far off. Were geometry and effect fitted together?")
    require(shares["interval"] == 1, "The size is right; the interval misses it, or is so wide that it says nothing.")
    return "Size and interval are right."


@check("Commands that bring the tip along the line")
def line(commands: Any, robot: int) -> str:
    """Hold corrected commands against the arm itself."""
    q = np.asarray(commands, dtype=float)
    require(q.ndim == 2 and q.shape[1] == 3, f"An array (N, 3) of commands is wanted, yours has shape {q.shape}.")
    require(5 <= len(q) <= 200, f"5 to 200 points are wanted, yours are {len(q)}.")
    require(bool(np.isfinite(q).all()), "Some commands are no numbers.")
    before, after = line_errors_mm(practice_robot(robot).world, q)
    require(
        after < before, f"The tip misses the line by {after:.2g} mm, with the drawing's commands by {before:.2g} mm."
    )
    require(after < (1 - _LINE) * before, f"From {before:.2g} mm to {after:.2g} mm; nine tenths of it can go.")
    return f"From {before:.2f} mm to {after:.2f} mm."


def _poses(answer: Any) -> Array:
    q = np.asarray(answer, dtype=float)
    try:
        check_poses(q)
    except InputError as error:
        raise WrongAnswerError(str(error)) from None
    return q


def _answer(answer: Any) -> dict[str, Any]:
    require(isinstance(answer, Mapping), "A dictionary is wanted: cause, joint, parameter, value, low, high.")
    try:
        return Answer(**answer).model_dump()
    except ValidationError as error:
        first = error.errors()[0]
        raise WrongAnswerError(f"{'.'.join(map(str, first['loc']))} {first['msg']}".strip()) from None


def _shares(said: dict[str, Any], robot: int) -> dict[str, float]:
    effects = practice_robot(robot).truth["effects"]
    return shares_of(Rubric(), effects[0] if effects else None, said, None)
