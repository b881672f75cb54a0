"""A twin moved by MuJoCo: the nominal servo at every joint, and what was found of it made physically."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from armtwin.models.catalogue.motion_injection import MotionCause, with_causes
from armtwin.models.motion_arm import MotionArm
from armtwin.models.motion_world import Motion, ideal_motion_world
from armtwin.sim.motion.simulation import simulate_motion

Array = NDArray[np.float64]


def simulate_twin_motion(
    causes: Sequence[MotionCause],
    arm: MotionArm,
    motions: Sequence[Motion],
    starts: Sequence[Array | None] | None = None,
    zeros_rad: Array | None = None,
) -> Array:
    """Return what the twin of an arm reads, (N, n) rad, in all rows of the motions.

    `causes` are (effect, site, parameters), made by the same injectors as in a sealed world. `starts` are the poses,
    (n,) rad as they read, in which the motions begin: those measured first. `zeros_rad` (n,) is what a joint reads
    where the model's angle is zero. Raises `InputError` as `inject_in_motion` does.
    """
    world = with_causes(ideal_motion_world(arm, zeros_rad), causes)
    return simulate_motion(world, motions, starts)
