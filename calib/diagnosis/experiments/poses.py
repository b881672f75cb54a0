"""Candidate plans, by the names under which effects ask for them (`Effect.plans`)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from models.effects.context import Context

Array = NDArray[np.float64]

# Beyond the joint angles that the recording has visited, a tenth of their range is taken to be safe, and at least 3
# degrees, so that a joint that was held still can be moved at all.
_MARGIN_SHARE = 0.1
_LEAST_MARGIN_RAD = 0.05
# Steps after a reversal: from below a good servo's play to beyond a bad one's.
_FINEST_STEP_RAD = 0.002
_POSES = 24
# A mass that a hobby servo holds at arm's length, and that shows.
PAYLOAD_KG = 0.1


@dataclass(frozen=True, eq=False)
class Candidate:
    """Poses that may be run after a recording: (K, n) commands, (K,) payload, and what a person has to do."""

    name: str
    q_cmd: Array
    payload_kg: Array
    what: str
    instructions: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class Space:
    """Where an arm may go: its context and (n, 2) lowest and highest command of each joint."""

    context: Context
    ranges: Array

    @property
    def rest(self) -> Array:
        """(n,) the middle of what the recording visited."""
        return np.asarray(np.median(self.context.q_cmd, axis=0))


def space_of(context: Context) -> Space:
    """Return the joint ranges of a recording with a sensible margin."""
    low, high = context.q_cmd.min(axis=0), context.q_cmd.max(axis=0)
    margin = np.maximum(_MARGIN_SHARE * (high - low), _LEAST_MARGIN_RAD)
    return Space(context, np.stack([low - margin, high + margin], axis=-1))


def reversal(space: Space, joint: int) -> Candidate:
    """Fine steps of one joint after each of six reversals, three from either side."""
    low, high = space.ranges[joint]
    steps = _FINEST_STEP_RAD * 1.7 ** np.arange(8)
    path: list[float] = []
    for share in (0.3, 0.5, 0.7):
        turn = low + share * (high - low)
        for side in (1.0, -1.0):
            reach = turn - side * 0.25 * (high - low)
            path += [reach, turn, *(turn - side * np.cumsum(steps))]
    what = f"joint {joint + 1} turns back at three places from either side and goes on in steps that grow"
    return _of_joint("reversal", space, joint, np.array(path), what)


def growing_steps(space: Space, joint: int) -> Candidate:
    """Steps there and back of one joint, each larger than the one before."""
    low, high = space.ranges[joint]
    middle, reach = 0.5 * (low + high), 0.5 * (high - low)
    sizes = np.geomspace(_FINEST_STEP_RAD, 0.95 * reach, 2 * _POSES)
    what = f"joint {joint + 1} steps there and back, every step larger than the one before"
    return _of_joint("growing_steps", space, joint, middle + sizes * (-1.0) ** np.arange(len(sizes)), what)


def fine_ramp(space: Space, joint: int) -> Candidate:
    """A slow ramp of one joint in steps far below a degree, upwards and back."""
    low, high = space.ranges[joint]
    middle = 0.5 * (low + high)
    up = middle + 0.75 * _FINEST_STEP_RAD * np.arange(1.5 * _POSES)
    what = f"joint {joint + 1} creeps up and back in steps of {np.degrees(0.75 * _FINEST_STEP_RAD):.2f} degrees"
    return _of_joint("fine_ramp", space, joint, np.concatenate([up, up[::-1]]), what)


def full_sweep(space: Space, joint: int) -> Candidate:
    """One joint over all of its range, there and back."""
    low, high = space.ranges[joint]
    up = np.linspace(low, high, _POSES)
    what = f"joint {joint + 1} sweeps its whole range, there and back"
    return _of_joint("full_sweep", space, joint, np.concatenate([up, up[::-1]]), what)


def stretched_and_folded(space: Space, joint: int) -> Candidate:
    """Poses of the largest and of the smallest torque of gravity about a joint, by turns."""
    q = _scattered(space, 40 * _POSES)
    torque = space.context.declared_torque_of(q)[:, joint] if False else _torque(space, q)[:, joint]
    order = np.argsort(torque)
    picked = np.stack([order[: _POSES // 2], order[: -_POSES // 2 - 1 : -1]], axis=-1).ravel()
    what = f"the arm is stretched and folded by turns, so that gravity's torque about joint {joint + 1} changes most"
    return Candidate(f"stretched_and_folded_{joint + 1}", q[picked], np.zeros(len(picked)), what)
