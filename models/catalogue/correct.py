"""Inverse kinematics of the extended twin: the commands that bring a real arm, with its effects, to wanted poses.

The geometry alone is inverted by `inverse_kinematics`. What the effects add depends on the commands, and for
play, friction or lag on all the commands before, so the sequence is corrected as a whole: every command is moved by
what the predicted link angle still misses, until nothing moves.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armtwin.models.catalogue.context import Context
from armtwin.models.catalogue.predict import Active, joint_angles
from armtwin.models.inverse_kinematics import inverse
from armtwin.models.kinematics import Deviation

Array = NDArray[np.float64]

_ITERATIONS = 40
_CLOSED_RAD = 1e-9


@dataclass(frozen=True, eq=False)
class Correction:
    """(N, n) commands, rad, and the largest link angle by which each pose is still missed, (N,) rad."""

    q_cmd: Array
    missed_rad: Array


def corrected_commands(history: Context, deviation: Deviation, effects: Sequence[Active], poses: Array) -> Correction:
    """Return commands for (N, 3) poses (x mm, y mm, theta rad) that follow on the commands of `history`.

    Raises `UnreachablePoseError`. Where an effect cannot be undone (rounded commands, a dead band) the commands that
    miss least are returned.
    """
    wanted = inverse(history.arm, poses, delta=deviation)
    command = wanted.copy()
    best, best_missed = command, np.full(len(command), np.inf)
    for _ in range(_ITERATIONS):
        missed = wanted - joint_angles(history.followed_by(command, "corrected"), effects)[len(history) :]
        worst = np.abs(missed).max(axis=1)
        if np.linalg.norm(worst) < np.linalg.norm(best_missed):
            best, best_missed = command, worst
        if worst.max() < _CLOSED_RAD:
            break
        command = command + missed
    return Correction(best, best_missed)
