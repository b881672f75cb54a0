"""Lab 6: the next experiment.

**Goals.** The student computes what two models leave of each other when all that is unknown is fitted along; sees
that signatures that look different are the same to an experiment; designs twenty poses by an argument of physics and
judges them by a number before he measures; reports a size with a standard deviation that his own plan implies.

**Before.** Lab 4.

**Time.** 75 minutes: 20 for what is left, 25 for the poses, 20 for verdict and size, 10 for the question.

**Where they get stuck.** *What is left*: they forget that the other cause's size is free. *The poses*: random poses
of a third of a radian reach 6 to 8; the torque at joint 1 depends on where links 2 and 3 are, the servo's error does
not, so keep joint 1 at a few angles and fold and stretch the others. *The size*: the geometry belongs in the fit;
without it the standard deviation is far too small and the size wrong.

**The question.** A few repeats (is it the same again, from both sides?), some poses that the named cause predicts to
be quiet, and some held out: a fit that explains the twenty and misses those has the wrong cause.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from armtwin.scenarios.labs.material.experiment import NOISE_MM, geometry, measure, paper_poses, signature

Array = NDArray[np.float64]


def left_over(signature: Array, other: Array, J: Array) -> Array:
    """Project out the other cause and the geometry."""
    M = np.column_stack([J, other])
    return np.asarray(signature - M @ np.linalg.lstsq(M, signature, rcond=1e-8)[0])


def stretched_and_folded() -> Array:
    """Joint 1 at five angles, the others folded and stretched at each."""
    others = [(-0.1, 0.3), (0.75, -0.9), (0.3, -0.2), (0.6, 0.2)]
    return np.array([[q1, q2, q3] for q1 in (-0.35, -0.17, 0.0, 0.17, 0.35) for q2, q3 in others])


def fitted(cause: str, q: Array) -> tuple[float, float, float]:
    """Return size, its standard deviation, and what is left over the noise, of a cause fitted with the geometry."""
    y, s, J = measure(q).ravel(), signature(cause, q).ravel(), geometry(q)
    alone = s - J @ np.linalg.lstsq(J, s, rcond=1e-8)[0]
    size = float(alone @ y / (alone @ alone))
    M = np.column_stack([J, s])
    rest = y - M @ np.linalg.lstsq(M, y, rcond=1e-8)[0]
    return size, NOISE_MM / float(np.linalg.norm(alone)), float(np.sqrt(rest @ rest / (len(y) - 7)) / NOISE_MM)


_POSES = stretched_and_folded()
_SIZE, _STD, _ = fitted("servo_gain", _POSES)
SOLUTION: dict[str, Any] = {
    "left_over": left_over,
    "my_poses": _POSES,
    "verdict": "servo_gain",
    "size": (_SIZE, _STD),
}
WRONG: dict[str, list[Any]] = {
    "left_over": [lambda signature, other, J: left_over(signature, J[:, 0], J)],
    "my_poses": [paper_poses(), np.zeros((40, 3)), np.full((20, 3), 2.0)],
    "verdict": ["gravity_sag", "the camera"],
    "size": [(0.3, 0.001), "small"],
}
