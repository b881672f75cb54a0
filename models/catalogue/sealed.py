"""How an effect is hidden in a sealed world: which sizes and shapes of it are drawn.

Each effect has one amplitude, which is scaled until the markers move as far as the wanted strength says; all else
(signs, directions, joints, times) is drawn. What is drawn is given to the injector, so nothing here knows the term.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from armtwin.models.arm import Arm
from armtwin.models.catalogue.site import NOWHERE, Site

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Situation:
    """What an effect is drawn for: the arm, the number of poses, the recording's span, the markers looked for.

    `steps` says how far the markers move from one pose to the next, (N,) pixels, to an effect that asks (the arm has
    to be moved for it), and `target_px` is how far the effect is to move them.
    """

    arm: Arm
    n_poses: int
    span_s: float
    markers: tuple[str, ...]
    steps: Callable[[], Array]
    target_px: float


@dataclass(frozen=True, eq=False)
class Hidden:
    """An effect at a place: `parameters` of an amplitude, to be scaled from `start` up to at most `most`.

    Where `most` is `start` the amplitude is not scaled: the effect moves the markers as far as it does.
    """

    parameters: Callable[[float], dict[str, Any]]
    start: float
    most: float
    site: Site = NOWHERE


Draw = Callable[[Generator, Situation], Hidden]


@dataclass(frozen=True)
class Sealing:
    """How an effect is hidden.

    Attributes:
        draw: draws its shape and place, and says how its amplitude is scaled.
        in_gravity: it shows only where gravity pulls in the arm's plane.
        timed: it shows only where time was recorded.
        all_markers: it shows only where more is looked for than base and tip.

    """

    draw: Draw
    in_gravity: bool = False
    timed: bool = False
    all_markers: bool = False


def scaled(name: str, start: float, most: float) -> Sealing:
    """Hide an effect of one parameter, its amplitude, at any joint."""
    return Sealing(lambda rng, situation: Hidden(lambda a: {name: a}, start, most, any_joint(rng, situation)))


def sign(rng: Generator) -> float:
    """Draw -1 or 1."""
    return 1.0 if rng.random() < 0.5 else -1.0


def any_joint(rng: Generator, situation: Situation) -> Site:
    """Draw a joint."""
    return Site(joint=int(rng.integers(1, situation.arm.n_joints + 1)))


def event(rng: Generator, situation: Situation) -> int:
    """Draw a sample of the recording's middle half."""
    return int(rng.integers(round(0.25 * situation.n_poses), round(0.75 * situation.n_poses)))


def direction(rng: Generator, dimensions: int) -> Array:
    """Draw a unit vector."""
    v = rng.standard_normal(dimensions)
    return np.asarray(v / np.linalg.norm(v))


def camera_motion(rng: Generator) -> Callable[[float], dict[str, Any]]:
    """Draw how a camera is turned and shifted."""
    turn, shift = direction(rng, 3), 0.3 * 485.0 * direction(rng, 3)  # mm per rad: half a turn about the arm's plane

    def parameters(a: float) -> dict[str, Any]:
        rotations = {f"rotation_{axis}_rad": a * v for axis, v in zip("xyz", turn, strict=True)}
        return rotations | {f"translation_{axis}_mm": a * v for axis, v in zip("xyz", shift, strict=True)}

    return parameters
