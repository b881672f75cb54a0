"""Planar kinematics: equations (2) to (9), with the sign of (8) corrected, and the deviated model (17, 18).

A planar chain is a sum of complex numbers, one a link: link i points along the sum of the joint angles up to i.
That form serves any number of joints; a tip offset makes the last link the complex length l4 - j l5, since C, E and F
are one rigid body (section 2.1).

Equation (8) as printed has a wrong sign: forward(inverse(p)) misses p on the paper's own circles by up to 48 mm in one
coordinate (63 mm in distance) with the 15 mm radius, and by 69 mm (92 mm) with the 25 mm radius. Here
theta1 = atan2(-(C_y l2 c2 + C_x (l1 - l2 s2)), (l1 - l2 s2) C_y - l2 c2 C_x), which closes to rounding.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from armtwin.models.arm import Arm
from armtwin.models.errors import InputError, UnreachablePoseError

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Elbow = Literal["paper", "other"]


@dataclass(frozen=True, eq=False)
class Deviation:
    """What the built arm differs by from the drawing: link lengths, mm, and joint zeros, rad (section 4)."""

    lengths_mm: Array
    joints_rad: Array

    @classmethod
    def none(cls, arm: Arm) -> Deviation:
        """Return no deviation for `arm`."""
        return cls(np.zeros_like(arm.link_lengths_mm), np.zeros(arm.n_joints))


def complex_links(arm: Arm, delta: Deviation | None = None) -> Complex:
    """(n,) each link as a complex length in its own frame; with a tip offset the last is l4 - j l5."""
    lengths = arm.link_lengths_mm if delta is None else arm.link_lengths_mm + delta.lengths_mm
    if arm.has_tip_offset:
        return np.array([*lengths[:-2], lengths[-2] - 1j * lengths[-1]])
    return lengths.astype(complex)


def path_to(arm: Arm, marker: str) -> tuple[tuple[int, int], ...]:
    """Return the way from the base to `marker`: (coefficient, link) pairs, counted from 0.

    Coefficient i is link i as a complex length; a marker on the corner of the last link has coefficient n instead,
    the link without its tip offset, which turns with the same link.
    """
    reach = arm.links_to(marker)
    way = [(link, link) for link in range(reach)]
    if arm.is_corner(marker):
        way[-1] = (reach, reach - 1)
    return tuple(way)


def link_angles(arm: Arm, q: Array, delta: Deviation | None = None) -> Array:
    """(N, n) direction of each link against the robot's x axis, rad, for (N, n) joint angles."""
    joints = q + arm.zero_pose_rad
    if delta is not None:
        joints = joints + delta.joints_rad
    angles: Array = np.cumsum(joints, axis=-1)
    return angles


def marker_positions(arm: Arm, q: Array, delta: Deviation | None = None) -> Array:
    """(N, n+1, 2) markers on the axes and the tip in the robot frame, mm, A first (equations 2, 3, 17, 18)."""
    links = complex_links(arm, delta) * np.exp(1j * link_angles(arm, q, delta))
    points = np.concatenate([np.zeros_like(links[..., :1]), np.cumsum(links, axis=-1)], axis=-1)
    return np.stack([points.real, points.imag], axis=-1)


def forward(arm: Arm, q: Array, delta: Deviation | None = None) -> Array:
    """(N, 3) tip position, mm, and orientation, rad, for (N, n) joint angles (equations 2 to 4, or 17 and 18)."""
    tip = marker_positions(arm, q, delta)[..., -1, :]
    joints = q if delta is None else q + delta.joints_rad
    theta = joints.sum(axis=-1) + arm.form.tip_turn_rad
    return np.concatenate([tip, theta[..., None]], axis=-1)


def coefficients(arm: Arm, delta: Deviation | None = None) -> tuple[Complex, Complex]:
    """Return the (C,) coefficients of a chain and their (C, lengths + n) derivative by lengths and joint zeros.

    A joint's zero turns every link beyond it by a constant angle, so that link i is c_i = l_i exp(j (delta_1 + ... +
    delta_i)). C = n; with a tip offset the last link's is l4 - j l5, and one more, l4, leads to its corner.
    """
    n, n_lengths = arm.n_joints, len(arm.link_lengths_mm)
    lengths = arm.link_lengths_mm if delta is None else arm.link_lengths_mm + delta.lengths_mm
    turn = np.exp(1j * np.cumsum(np.zeros(n) if delta is None else delta.joints_rad))
    slope = np.zeros((n + arm.has_tip_offset, n_lengths + n), dtype=complex)
    slope[range(n), range(n)] = turn
    if arm.has_tip_offset:
        l4, l5 = lengths[-2:]
        c = np.array([*lengths[:-2], l4 - 1j * l5, l4]) * turn[[*range(n), n - 1]]
        slope[n - 1, n] = -1j * turn[n - 1]
        slope[n, n - 1] = turn[n - 1]
    else:
        c = lengths * turn
    for link in range(len(c)):
        slope[link, n_lengths : n_lengths + min(link, n - 1) + 1] = 1j * c[link]
    return c, slope


def along_path(arm: Arm, directions: Complex, marker: str) -> Complex:
    """(N, C) what each coefficient of a chain is multiplied with to reach `marker`: its derivative by them.

    `directions` are (N, n) unit directions of the links in which the joints' zeros have no part.
    """
    out = np.zeros((len(directions), arm.n_joints + arm.has_tip_offset), dtype=complex)
    for coefficient, link in path_to(arm, marker):
        out[:, coefficient] = directions[:, link]
    return out


def by_joint(arm: Arm, along: Complex, c: Complex) -> Complex:
    """(N, n) derivative of a marker by the joint angles: what lies beyond a joint turns about it.

    `along` (N, C) is the marker's `along_path`, `c` (C,) the chain's coefficients.
    """
    links = along * c
    n = arm.n_joints
    beyond = links[:, :n].copy()
    beyond[:, n - 1] += links[:, n:].sum(axis=-1)  # the corner is on the last link
    turned: Complex = 1j * np.cumsum(beyond[:, ::-1], axis=-1)[:, ::-1]
    return turned


def forward_jacobian(arm: Arm, q: Array, delta: Deviation | None = None) -> tuple[Array, Array]:
    """Derivatives of every marker position: (N, n+1, 2, lengths) mm/mm and (N, n+1, 2, n) mm/rad by joint zeros.

    The derivative by a joint's zero is the derivative by its angle.
    """
    _, slope = coefficients(arm, delta)
    directions = np.exp(1j * link_angles(arm, q))
    moved = np.stack([along_path(arm, directions, name) @ slope for name in arm.marker_names], axis=1)
    n_lengths = len(arm.link_lengths_mm)
    return _as_xy(moved[..., :n_lengths]), _as_xy(moved[..., n_lengths:])


def is_closed_form(arm: Arm) -> bool:
    """Whether equations (5) to (9) hold for `arm`: three joints, quarter turns at zero, a bent last link."""
    form = arm.form
    return arm.n_joints == 3 and form.tip_offset and form.zero_turn_rad == np.pi / 2 and form.tip_turn_rad == np.pi


def inverse(arm: Arm, poses: Array, elbow: Elbow = "paper", delta: Deviation | None = None) -> Array:
    """(N, 3) joint commands, rad, that bring the tip of the paper's arm to (N, 3) poses x mm, y mm, theta rad (5 to 9).

    `elbow` chooses the branch of equation (7): the paper's arcsine, or the other one. With `delta` the commands are
    those of the deviated arm. Raises `UnreachablePoseError` that names the first pose out of reach and the reach.
    """
    if not is_closed_form(arm):
        raise InputError(f"the closed form is for arms joined like the paper's, found arm '{arm.name}'")
    deviation = Deviation.none(arm) if delta is None else delta
    l1, l2, l4, l5 = arm.link_lengths_mm + deviation.lengths_mm
    x, y, theta_F = np.asarray(poses, dtype=float).T
    Cx = x - l4 * np.sin(theta_F - np.pi) + l5 * np.cos(theta_F - np.pi)
    Cy = y + l4 * np.cos(theta_F - np.pi) + l5 * np.sin(theta_F - np.pi)
    argument = (Cx**2 + Cy**2 - l1**2 - l2**2) / (2 * l1 * l2)
    _refuse_unreachable(poses, argument, np.hypot(Cx, Cy), l1, l2)
    theta2 = -np.arcsin(argument) if elbow == "paper" else np.pi + np.arcsin(argument)
    s2, c2 = np.sin(theta2), np.cos(theta2)
    theta1 = np.arctan2(-(Cy * l2 * c2 + Cx * (l1 - l2 * s2)), (l1 - l2 * s2) * Cy - l2 * c2 * Cx)
    theta3 = theta_F - theta1 - theta2 - np.pi
    return wrap(np.stack([theta1, theta2, theta3], axis=-1) - deviation.joints_rad)


def wrap(angle: Array) -> Array:
    """Bring angles, rad, into (-pi, pi]."""
    return np.pi - np.mod(np.pi - angle, 2 * np.pi)


def _refuse_unreachable(poses: Array, argument: Array, distance: Array, l1: float, l2: float) -> None:
    far = ~(np.abs(argument) <= 1.0)
    if far.any():
        row = int(np.argmax(far))
        x, y, theta = np.asarray(poses)[row]
        raise UnreachablePoseError(
            f"pose {row} (x {x:.2f} mm, y {y:.2f} mm, theta {np.degrees(theta):.2f} deg) is out of reach: joint C "
            f"would be {distance[row]:.2f} mm from A, the arm reaches {abs(l1 - l2):.2f} to {l1 + l2:.2f} mm"
        )


def _as_xy(z: Complex) -> Array:
    """(..., M, P) complex derivatives as (..., M, 2, P) real ones."""
    return np.stack([z.real, z.imag], axis=-2)
