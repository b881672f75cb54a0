"""The planar chain as it is fitted: every marker is a sum of complex link coefficients.

A joint's zero turns every link beyond it by a constant angle, so with the commanded directions exp(j Theta_i) known,

    marker = base + sum_i c_i exp(j Theta_i),    c_i = l_i exp(j (delta_1 + ... + delta_i)),

is linear in the coefficients c. A tip offset brings the coefficients l4 - j l5 for F and, on the same body, l4 for E
(equations 17 and 18 written as complex numbers).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armtwin.models.arm import Arm
from armtwin.models.kinematics import Deviation, along_path, coefficients, link_angles

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

BASE_NAMES = ("base_x_mm", "base_y_mm")

# How far a built arm may be from its drawing. These spreads decide only what the data leave open, and what counts as
# known. Lengths: the largest deviation in Table 4 is 6.7 mm, taken fivefold. Joint zeros: a hobby servo's spline has
# 25 teeth, so a horn set two teeth off turns by 0.5 rad.
LENGTH_SPREAD_MM = 30.0
JOINT_SPREAD_RAD = 0.5


@dataclass(frozen=True, eq=False)
class Chain:
    """The parameters of an arm's geometry, (lengths, joint zeros), and the coefficients that they make."""

    arm: Arm

    @property
    def length_names(self) -> tuple[str, ...]:
        """`delta_l1_mm`, ..., numbered as the arm has it (l1, l2, l4, l5 in the paper)."""
        return tuple(f"delta_l{number}_mm" for number in self.arm.length_numbers)

    @property
    def joint_names(self) -> tuple[str, ...]:
        """`delta_theta1_rad`, ..."""
        return tuple(f"delta_theta{joint + 1}_rad" for joint in range(self.arm.n_joints))

    @property
    def names(self) -> tuple[str, ...]:
        """The link parameters in the order in which they are fitted."""
        return self.length_names + self.joint_names

    @property
    def spreads(self) -> Array:
        """(P,) how far each link parameter may be from the drawing, mm and rad (one standard deviation)."""
        return np.array([LENGTH_SPREAD_MM] * len(self.length_names) + [JOINT_SPREAD_RAD] * len(self.joint_names))

    def deviation(self, link_parameters: Array) -> Deviation:
        """Split (P,) link parameters into lengths and joint zeros."""
        n_lengths = len(self.length_names)
        return Deviation(link_parameters[:n_lengths].copy(), link_parameters[n_lengths:].copy())

    def coefficients(self, link_parameters: Array) -> tuple[ComplexArray, ComplexArray]:
        """Return the (C,) coefficients c and their (C, P) derivative by the link parameters; C = n, or n + 1 with E."""
        return coefficients(self.arm, self.deviation(link_parameters))

    def directions(self, q_cmd: Array, marker: str) -> ComplexArray:
        """(N, C) what each coefficient is multiplied with to reach `marker` at (N, n) commands, rad."""
        return along_path(self.arm, np.exp(1j * link_angles(self.arm, q_cmd)), marker)

    def convention(self, markers: tuple[str, ...]) -> Array:
        """(P, P') basis of the link parameters that are fitted when these markers are seen.

        Without E, a last link C-F with a tip offset is seen as one vector: turning (l4, l5) and turning theta3's zero
        are the same motion. The link is then taken to have the drawn angle at C (one printed part), so that delta_l5
        follows delta_l4 in the drawn ratio l5 / l4, and the turn stands in delta_theta3, whose horn is mounted by hand.
        """
        basis = np.eye(len(self.names))
        if not self.has_last_link_gauge(markers):
            return basis
        last = self.arm.n_joints  # the offset stands behind the links
        basis[last, last - 1] = self.arm.link_lengths_mm[-1] / self.arm.link_lengths_mm[-2]
        return np.delete(basis, last, axis=1)

    def has_last_link_gauge(self, markers: tuple[str, ...]) -> bool:
        """Whether the last zero and the direction of (l4, l5) are one motion: a tip offset whose corner is not seen."""
        return self.arm.has_tip_offset and self.arm.form.corner not in markers and self.arm.link_lengths_mm[-2] > 0

    def in_convention(self, delta: Deviation) -> Deviation:
        """Return the deviation that moves F alike and keeps the last link's drawn angle (else `delta`)."""
        if not self.arm.has_tip_offset:
            return delta
        l4, l5 = self.arm.link_lengths_mm[-2:]
        drawn = complex(l4, -l5)
        built = complex(l4 + delta.lengths_mm[-2], -(l5 + delta.lengths_mm[-1]))
        scale = abs(built) / abs(drawn)
        lengths, joints = delta.lengths_mm.copy(), delta.joints_rad.copy()
        lengths[-2:] = np.array([l4, l5]) * (scale - 1.0)
        joints[-1] += float(np.angle(built / drawn))
        return Deviation(lengths, joints)
