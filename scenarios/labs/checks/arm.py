"""Lab 3: D-H, equation 8's sign, branches, reach."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from armtwin.models import kinematics
from armtwin.models.arm import nominal_arm
from armtwin.models.trajectories import circle
from armtwin.scenarios.labs.check import array, check, number, require

Array = NDArray[np.float64]

_CLOSED_MM = 1e-6
_TARGET = np.array([-130.0, 40.0, np.pi])


@check("One row of a D-H table as a transform")
def dh(answer: Callable[..., Any]) -> str:
    """Hold a D-H transform against its four factors."""
    for theta, d, a, alpha in (
        (0.3, 0.0, 0.0, 0.0),
        (0.0, 5.0, 0.0, 0.0),
        (0.0, 0.0, 7.0, 0.0),
        (0.0, 0.0, 0.0, 0.4),
        (0.5, 2.0, 3.0, -0.7),
    ):
        found = array(answer(theta, d, a, alpha), (4, 4), "dh")
        wanted = _dh(theta, d, a, alpha)
        said = f"With theta {theta:g}, d {d:g}, a {a:g}, alpha {alpha:g}"
        require(not (np.allclose(found, wanted.T) and not np.allclose(wanted, wanted.T)), f"{said} it is transposed.")
        order = np.round(np.abs(found - wanted).max(), 3)
        require(
            np.allclose(found, wanted),
            f"{said} an entry is off by {order:g}; the factors stand in the order of equation 1.",
        )
    return "Four elementary motions, one after the other."


@check("The forward kinematics: equations 2 to 4")
def forward(answer: Callable[..., Any]) -> str:
    """Hold a forward kinematics against the reference."""
    q = np.random.default_rng(3).uniform(-1.2, 1.2, (7, 3))
    found = array(answer(q.copy()), (7, 3), "forward")
    wanted = kinematics.forward(nominal_arm(), q)
    turn = np.abs(kinematics.wrap(found[:, 2] - wanted[:, 2])).max()
    for column, name in enumerate(("x", "y")):
        off = np.abs(found[:, column] - wanted[:, column]).max()
        require(off < 1e-6, f"{name} is off by up to {off:.3g} mm; with all joints at zero it has to be Figure 1.")
    require(turn < 1e-9, f"The orientation is off by up to {turn:.3g} rad: it is the sum of the joints and something.")
    return "Seven poses to rounding."


@check("How far does the printed inverse miss, on the 15 mm circle?")
def printed(answer: Any) -> str:
    """Hold the largest miss of the loop with equation 8 as printed."""
    found = number(answer, "worst_mm")
    wanted = float(np.linalg.norm(_loop(_printed), axis=1).max())
    axes = float(np.abs(_loop(_printed)).max())
    require(not np.isclose(found, axes, rtol=0.01), "That is the largest miss of one coordinate: take the distance.")
    require(
        abs(found - wanted) < 0.5,
        f"Largest distance of FK(IK(p)) from p over the 50 poses; yours is {found / wanted:.2g} times it.",
    )
    return "A formula in print, and nobody closed the loop."


@check("The inverse, mended: the loop closes")
def inverse(answer: Callable[..., Any]) -> str:
    """Hold an inverse against its own forward kinematics, naming the first joint that is wrong."""
    poses = np.concatenate([circle((-130.0, 40.0), r) for r in (5.0, 15.0, 25.0)])
    q = array(answer(poses.copy()), (150, 3), "inverse")
    wanted = kinematics.inverse(nominal_arm(), poses)
    miss = np.linalg.norm(kinematics.forward(nominal_arm(), q)[:, :2] - poses[:, :2], axis=1).max()
    if miss >= _CLOSED_MM:
        bad = [f"theta{k + 1}" for k in range(3) if np.abs(kinematics.wrap(q[:, k] - wanted[:, k])).max() > 1e-6]
        first = "theta2" if "theta2" in bad else bad[0]
        require(False, f"FK(IK(p)) misses p by up to {miss:.3g} mm; {first} is the first to look at.")
    turn = np.abs(kinematics.wrap(q.sum(axis=1) - poses[:, 2] + np.pi)).max()
    require(turn < 1e-9, "The tip arrives, but turned otherwise than asked for.")
    return f"It misses by {miss:.1g} mm: rounding."


@check("Both branches of the centre of the circles")
def branches(answer: Callable[..., Any]) -> str:
    """Hold two different solutions of one pose."""
    both = array(answer(_TARGET.copy()), (2, 3), "branches")
    places = kinematics.forward(nominal_arm(), both)
    for number_, place in enumerate(places):
        off = float(np.linalg.norm(place[:2] - _TARGET[:2]))
        require(off < _CLOSED_MM, f"Row {number_} brings the tip {off:.3g} mm beside the target.")
        turned = float(np.abs(kinematics.wrap(place[2:] - _TARGET[2])).max())
        require(turned < 1e-9, f"Row {number_} brings the tip there, turned otherwise than asked for.")
    apart = float(np.abs(kinematics.wrap(both[0] - both[1])).max())
    require(
        apart > 0.1,
        "Both rows are the same branch. Which angle has the sine that equation 7 asks for, beside the arcsine?",
    )
    return "The same pose of the tip, elbow to either side."


@check("How near to A and how far from it can C be, mm?")
def reach(answer: Any) -> str:
    """Hold the two radii of the ring that C can reach."""
    near, far = array(answer, (2,), "reach_mm")
    l1, l2 = nominal_arm().link_lengths_mm[:2]
    require(near < far, "Nearest first, then farthest.")
    require(abs(far - (l1 + l2)) < 0.01, f"Farthest: {far:g} mm is not where the two links are stretched out.")
    require(abs(near - abs(l1 - l2)) < 0.01, f"Nearest: at {near:g} mm the elbow is not folded altogether.")
    return "A ring, as long as no servo has an end. Look at the picture for what the servos' ends leave of it."


def printed_inverse(poses: Array) -> Array:
    """Return equations 5 to 9 as they stand in the paper."""
    return _printed(poses)


def _dh(theta: float, d: float, a: float, alpha: float) -> Array:
    ct, st, ca, sa = np.cos(theta), np.sin(theta), np.cos(alpha), np.sin(alpha)
    return np.array([[ct, -st * ca, st * sa, a * ct], [st, ct * ca, -ct * sa, a * st], [0, sa, ca, d], [0, 0, 0, 1]])


def _printed(poses: Array) -> Array:
    l1, l2, l4, l5 = nominal_arm().link_lengths_mm
    x, y, theta = poses.T
    Cx = x - l4 * np.sin(theta - np.pi) + l5 * np.cos(theta - np.pi)
    Cy = y + l4 * np.cos(theta - np.pi) + l5 * np.sin(theta - np.pi)
    t2 = -np.arcsin((Cx**2 + Cy**2 - l1**2 - l2**2) / (2 * l1 * l2))
    s, c = np.sin(t2), np.cos(t2)
    t1 = -np.arctan((Cy * l2 * c - Cx * (l2 * s - l1)) / (Cx * l2 * c + Cy * (l2 * s - l1)))
    return np.stack([t1, t2, theta - t1 - t2 - np.pi], axis=-1)


def _loop(inverse_of: Callable[[Array], Array]) -> Array:
    poses = circle((-130.0, 40.0), 15.0)
    return kinematics.forward(nominal_arm(), inverse_of(poses))[:, :2] - poses[:, :2]
