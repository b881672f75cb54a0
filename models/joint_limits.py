"""Joint limits and the largest step, checked before anything is sent to the servos."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armtwin.models.arm import Arm
from armtwin.models.errors import InputError
from armtwin.models.plan import ROUNDING_RAD, Plan

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class JointLimits:
    """(n,) smallest and largest angle of each joint, rad, and the largest change of a joint from pose to pose.

    `labels` are the joints' for people; None: they are counted.
    """

    min_rad: Array
    max_rad: Array
    max_step_rad: float
    labels: tuple[str, ...] | None = None

    @classmethod
    def of_arm(cls, arm: Arm, turn_rad: float) -> JointLimits:
        """Return the drawing's limits, or `turn_rad` either way where it states none; from end to end in one step."""
        ends = arm.joint_limits_rad
        if ends is None:
            ends = np.tile([-turn_rad, turn_rad], (arm.n_joints, 1))
        return cls(ends[:, 0], ends[:, 1], float(np.max(ends[:, 1] - ends[:, 0])), arm.joint_labels)

    def _label(self, joint: int) -> str:
        return f"joint {joint + 1}" if self.labels is None else self.labels[joint]

    def check_pose(self, q: Array, where: str) -> None:
        """Raise `InputError`, naming `where` and the joint, if (n,) angles lie outside the limits or are no numbers."""
        if np.shape(q) != np.shape(self.min_rad):
            raise InputError(f"{where}: {len(self.min_rad)} joint angles wanted, found shape {np.shape(q)}")
        inside = (q >= self.min_rad - ROUNDING_RAD) & (q <= self.max_rad + ROUNDING_RAD)
        if not inside.all():  # NaN is not inside
            j = int(np.argmin(inside))
            raise InputError(
                f"{where}: {self._label(j)} at {q[j]:.4f} rad ({np.degrees(q[j]):.1f} deg) is outside its limits, "
                f"{self.min_rad[j]:.4f} to {self.max_rad[j]:.4f} rad"
            )

    def check_step(self, q_from: Array, q_to: Array, where: str) -> None:
        """Raise `InputError` if a joint would turn further than the largest step."""
        step = np.abs(q_to - q_from)
        j = int(np.argmax(step))
        if step[j] > self.max_step_rad + ROUNDING_RAD:
            raise InputError(
                f"{where}: {self._label(j)} turns {step[j]:.4f} rad in one step, {self.max_step_rad:.4f} is allowed; "
                "put poses between, or raise motion.max_step_rad"
            )

    def check_plan(self, plan: Plan, file: str) -> None:
        """Check every pose and every step of a plan before the first is sent; rows are counted as in a plan's CSV."""
        for row, q in enumerate(plan.q_cmd):
            where = f"{file}: line {row + 2} ({plan.trajectory[row]})"
            self.check_pose(q, where)
            if row:
                self.check_step(plan.q_cmd[row - 1], q, where)
