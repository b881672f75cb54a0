"""Where the physics has the bodies of an arm."""

from __future__ import annotations

import mujoco
import numpy as np
from numpy.typing import NDArray

from armtwin.models.units import MM_PER_M

Array = NDArray[np.float64]


def placements(model: mujoco.MjModel, data: mujoco.MjData) -> dict[str, Array]:
    """(4, 4) transforms, mm, that map the coordinates of each body (`link1`, `end1`, ...) to the robot frame."""
    out = {}
    for number in range(1, model.nbody):
        T = np.eye(4)
        T[:3, :3] = data.xmat[number].reshape(3, 3)
        T[:3, 3] = data.xpos[number] * MM_PER_M
        out[model.body(number).name] = T
    return out
