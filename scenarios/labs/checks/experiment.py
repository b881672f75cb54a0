"""Lab 6: what two causes leave of each other, twenty poses that tell, and the verdict."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from armtwin.models.errors import InputError
from armtwin.scenarios.labs.check import WrongAnswerError, array, check, number, require
from armtwin.scenarios.labs.material.experiment import (
    BUDGET,
    CAUSES,
    LIMITS,
    NOISE_MM,
    geometry,
    measure,
    paper_poses,
    signature,
    truth,
)

Array = NDArray[np.float64]

# The paper's circle separates the two by about one standard deviation, careless poses of a third of a radian by six.
_TELLS = 12.0
_FREE = 1e-8


@check("What is left of a signature when geometry and the other cause have explained what they can")
def left_over(answer: Callable[..., Any]) -> str:
    """Hold a projection against the reference."""
    rng = np.random.default_rng(60)
    J, other, signature_ = rng.normal(size=(30, 4)), rng.normal(size=30), rng.normal(size=30)
    J = np.column_stack([J, J[:, 0] - 2 * J[:, 1]])  # as geometry is: one column too many
    found = array(answer(signature_.copy(), other.copy(), J.copy()), (30,), "left_over")
    M = np.column_stack([J, other])
    wanted = _left(signature_, M)
    require(not np.allclose(found, _left(signature_, J)), "The other cause has not had its turn: its size is free too.")
    require(
        not np.allclose(found, signature_ - wanted), "That is the part that they explain; what they leave is asked for."
    )
    apart = np.abs(M.T @ found).max()
    require(
        np.allclose(found, wanted, atol=1e-6), f"What is left still has {apart:.2g} in common with what was taken out."
    )
    return "What is left is all that tells the two apart."


@check("Twenty poses that tell them apart")
def poses(answer: Any) -> str:
    """Hold a plan against budget, limits, picture, and the separation that it buys."""
    q = _plan(answer)
    here, paper = separation(q), separation(paper_poses())
    require(
        here > paper,
        f"They separate the two by {here:.1f} standard deviations; the paper's circle does by {paper:.1f}.",
    )
    require(
        here > _TELLS,
        f"{here:.1f} standard deviations apart (the paper's circle: {paper:.1f}); {_TELLS:g} is within reach.",
    )
    return f"{here:.1f} standard deviations apart, with the paper's circle {paper:.1f}."


@check("The verdict")
def verdict(answer: Any) -> str:
    """Hold the cause."""
    require(str(answer) in CAUSES, f"One of {', '.join(CAUSES)} is wanted.")
    require(str(answer) == truth(), "Fit both to what you measured: which one leaves more than the camera's noise?")
    return "It leaves the noise; the other does not."


@check("Its size and standard deviation, in units of the usual size")
def size(answer: Any, plan: Any) -> str:
    """Hold a size and its standard deviation against the truth and the plan."""
    found, std = array(answer, (2,), "size and its standard deviation")
    q = _plan(plan)
    require(std > 0, "A standard deviation is positive.")
    remains = _left(signature(truth(), q).ravel(), geometry(q))
    wanted = NOISE_MM / float(np.linalg.norm(remains))
    require(
        0.5 < std / wanted < 2.0,
        f"Your poses tell it to another width: yours is {std / wanted:.2g} times it. Is the geometry free?",
    )
    require(abs(found - 1.0) < 4 * wanted, f"It is {abs(found - 1.0) / wanted:.1f} standard deviations off.")
    return f"{100 * abs(found - 1):.1f} % off, and you said ±{100 * std:.1f} %."


def separation(q: Array) -> float:
    """Return how many standard deviations the two causes are apart at best, in the less favourable direction."""
    J = geometry(q)
    a, b = (signature(cause, q).ravel() for cause in CAUSES)
    left = [_left(one, np.column_stack([J, other])) for one, other in ((a, b), (b, a))]
    return float(min(np.linalg.norm(one) for one in left) / NOISE_MM)


def _left(y: Array, M: Array) -> Array:
    return np.asarray(y - M @ np.linalg.lstsq(M, y, rcond=_FREE)[0])


def _plan(answer: Any) -> Array:
    q = np.asarray(answer, dtype=float)
    require(q.ndim == 2 and q.shape[1:] == (3,), f"An array (N, 3) of commands is wanted, yours has shape {q.shape}.")
    require(len(q) <= BUDGET, f"The budget is {BUDGET} poses, yours are {len(q)}.")
    require(len(q) >= 6, "Fewer than 6 poses do not even tell the geometry.")
    try:
        for row, one in enumerate(q):
            LIMITS.check_pose(one, f"pose {row}")
    except InputError as error:
        raise WrongAnswerError(str(error)) from None
    unseen = np.flatnonzero(~np.isfinite(measure(q)).all(axis=1))
    require(not len(unseen), f"In pose {unseen[:1]} the arm leaves the picture: nothing is measured there.")
    number(len(q), "poses")
    return q
