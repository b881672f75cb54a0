"""How the loads of an arm turn with its pose, without trust in its masses or in where its zeros are.

The torque that gravity puts on a joint of a chain whose loaded joints are parallel is a sum of one sine and one cosine
for each link beyond it, of the link's heading: the sum of the angles up to it. Wrong masses change the amplitudes, a
wrong zero the phases, nothing else.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

# A joint that bears less than this is not loaded, N m; what the headings leave of a load, as a share of its variation.
_LOADED_NM, _LEFT = 5e-3, 0.05
_MOST_JOINTS = 7
_ROWS = 2000


@dataclass(frozen=True)
class Headings:
    """The loaded joints (from 0) of a chain, in their order, and in which sense each turns (1 or -1)."""

    joints: tuple[int, ...]
    senses: tuple[int, ...]

    def basis(self, q: Array, joint: int) -> Array:
        """(N, 2k) cosines and sines of the headings of the k links at and beyond a joint, at angles (N, n), rad."""
        if joint not in self.joints:
            return np.zeros((len(q), 0))
        heading = np.cumsum(q[:, list(self.joints)] * self.senses, axis=1)[:, self.joints.index(joint) :]
        return np.concatenate([np.cos(heading), np.sin(heading)], axis=1)


def headings_of(q: Array, loads_nm: Array) -> Headings | None:
    """Find the headings that loads (N, n), N m, follow over angles (N, n), rad; None where they follow none."""
    joints = tuple(int(j) for j in np.flatnonzero(np.ptp(loads_nm, axis=0) > _LOADED_NM))
    if not joints or len(joints) > _MOST_JOINTS:
        return None
    every = max(1, len(q) // _ROWS)
    few, loads = q[::every], loads_nm[::every]
    tried = [Headings(joints, (1, *senses)) for senses in itertools.product((1, -1), repeat=len(joints) - 1)]
    left, best = min(((_left(one, few, loads), k) for k, one in enumerate(tried)), key=lambda pair: pair[0])
    return tried[best] if left < _LEFT else None


def _left(headings: Headings, q: Array, loads_nm: Array) -> float:
    """Return the largest share that the headings leave of a joint's load."""
    shares = []
    for joint in headings.joints:
        X, load = headings.basis(q, joint), loads_nm[:, joint]
        share = np.linalg.lstsq(X, load, rcond=None)[0]
        shares.append(float(np.std(load - X @ share) / np.std(load)))
    return max(shares)
