"""From joint angles to pulse widths and back: one straight line a servo.

    pulse = zero_us + direction * us_per_rad * q

A servo's own curvature is not put here: it is an error of the arm (`servo_nonlinearity`) that the diagnosis looks for.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class ServoMap:
    """Which servo turns which joint, and how far for a pulse.

    Attributes:
        servo: (n,) index from 0 of the board's servo that turns each joint.
        zero_us: (n,) pulse width at q = 0.
        us_per_rad: (n,) signed slope: negative where the servo turns against the joint.

    """

    servo: NDArray[np.int64]
    zero_us: Array
    us_per_rad: Array

    def pulses_us(self, q: Array) -> Array:
        """(..., n) pulse widths, us, in the board's order of servos, for (..., n) joint angles, rad."""
        out = np.empty(np.shape(q))
        out[..., self.servo] = self.zero_us + self.us_per_rad * q
        return out

    def angles_rad(self, pulses_us: Array) -> Array:
        """(..., n) joint angles, rad, for (..., n) pulse widths, us, in the board's order: the inverse."""
        angles: Array = (np.asarray(pulses_us)[..., self.servo] - self.zero_us) / self.us_per_rad
        return angles

    def as_table(self) -> dict[str, Any]:
        """Return the map as plain data by joint; servos count from 1, a slope is negative where one turns against."""
        joints = zip(self.servo.tolist(), self.zero_us.tolist(), self.us_per_rad.tolist(), strict=True)
        return {
            f"joint {number}": {"servo": servo + 1, "zero_us": zero_us, "us_per_rad": us_per_rad}
            for number, (servo, zero_us, us_per_rad) in enumerate(joints, start=1)
        }
