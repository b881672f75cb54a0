"""Lab 4: an arm that was not built as it was drawn, on the paper's trajectories."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np
from numpy.typing import NDArray

from armtwin.models.arm import nominal_arm
from armtwin.models.camera_files import nominal_camera
from armtwin.models.kinematics import Deviation
from armtwin.models.plan import paper_plan
from armtwin.models.twin import Twin
from armtwin.scenarios.labs.material.tips import Tips, tips_of
from armtwin.scenarios.twins.simulation import simulate

Array = NDArray[np.float64]

NAMES = ("l1", "l2", "l4", "l5", "theta1", "theta2", "theta3")
DRAWN_MM = (120.0, 121.7, 38.0, 6.73)
FIT, HELD_OUT = ["circle_15", "circle_25"], ["line"]
BASE_MM = np.array([8.0, -6.0, -80.87])
# Of the size that the paper's Hough circles reach; a sub-pixel detector would be ten times better.
NOISE_PX = 0.5
_BUILT = Deviation(np.array([1.8, -1.4, 0.9, -0.6]), np.array([0.030, -0.045, 0.025]))


def measured_arm(seed: int = 4) -> tuple[Tips, Tips]:
    """Return what was measured on the two circles, and on the line, which is held out."""
    return _measured(seed)


def slope_of(tips: Tips) -> Callable[[Array], Array]:
    """Return the slope of the cost, (7,) mm²/mm and mm²/degree, at (7,) deviations in mm and degrees (equation 22)."""
    seen = tips.tip_mm[:, 0] + 1j * tips.tip_mm[:, 1]

    def slope(x: Array) -> Array:
        l1, l2, l4, l5 = np.array(DRAWN_MM) + x[:4]
        along = np.exp(1j * np.cumsum(tips.q_cmd + np.radians(x[4:]) + np.pi / 2, axis=1))
        ab, bc, cf = l1 * along[:, 0], l2 * along[:, 1], (l4 - 1j * l5) * along[:, 2]
        turns = [1j * np.radians(1.0) * reach for reach in (ab + bc + cf, bc + cf, cf)]
        by = np.array([along[:, 0], along[:, 1], along[:, 2], -1j * along[:, 2], *turns])
        return 2 * np.real(by.conj() @ (ab + bc + cf - seen)) / len(tips)

    return slope


@cache
def _measured(seed: int) -> tuple[Tips, Tips]:
    arm = nominal_arm()
    twin = Twin(arm, _BUILT, BASE_MM, nominal_camera(), ())
    recording = simulate(twin, paper_plan(arm), noise=NOISE_PX, seed=seed)
    return tips_of(recording, FIT), tips_of(recording, HELD_OUT)
