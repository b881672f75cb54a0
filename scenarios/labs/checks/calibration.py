"""Lab 4: cost, descent, what the data tell, least squares, intervals."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from armtwin.models.arm import nominal_arm
from armtwin.models.kinematics import Deviation, forward, forward_jacobian
from armtwin.scenarios.labs.check import array, check, copies, number, require
from armtwin.scenarios.labs.material.calibration import NAMES, measured_arm

Array = NDArray[np.float64]

_DEPENDS_ON_THE_START = {"l4", "l5", "theta3"}
# The drawing misses the line by 3.4 mm on average, least squares by 0.20 mm: the camera's half a pixel.
_HELD_OUT_MM = 0.26
# Over all poses, mm a unit step: what rounding and a Jacobian by differences leave, and no other direction comes near.
_SILENT = 0.01


@check("The cost is the mean squared distance of the tip, mm²")
def cost(answer: Callable[..., Any]) -> str:
    """Hold a cost against the reference at a few arms."""
    fit, _ = measured_arm()
    rng = np.random.default_rng(40)
    for delta in rng.normal(0, [2, 2, 2, 2, 0.05, 0.05, 0.05], (4, 7)):
        found = number(answer(*copies(delta, fit.q_cmd, fit.tip_mm)), "cost")
        wanted = float((_misses(delta) ** 2).sum(axis=1).mean())
        if np.isclose(found, np.sqrt(wanted), rtol=1e-6):
            require(False, "That is a distance in mm; the squares are to be averaged, and no root is taken.")
        require(not np.isclose(found, wanted * len(fit), rtol=1e-6), "That is the sum over all poses, not the mean.")
        require(not np.isclose(found, wanted / 2, rtol=1e-6), "A pose has two coordinates: add their squares first.")
        require(np.isclose(found, wanted, rtol=1e-6), f"At one arm you find {found:.4g} mm², it is {wanted:.4g} mm².")
    return "The drawing's own cost is the starting point of everything below."


@check("Each step goes down the slope")
def descent(answer: Callable[..., Any]) -> str:
    """Let a descent run in a bowl whose bottom is known."""
    curvature, bottom = np.array([4.0, 1.0, 0.5]), np.array([1.0, -2.0, 0.5])

    def slope(x: Array) -> Array:
        return curvature * (x - bottom)

    start, rate = np.array([3.0, 1.0, -1.0]), 0.2
    path = array(answer(slope, start.copy(), rate, 60), (61, 3), "descend")
    require(np.allclose(path[0], start), "The first row is to be the start itself.")
    step = path[1] - path[0]
    require(not np.allclose(step, rate * slope(start)), "Your first step goes uphill: look at its sign.")
    require(np.allclose(step, -rate * slope(start)), "The first step is not rate times the slope.")
    require(np.allclose(path[2] - path[1], -rate * slope(path[1])), "The second step uses the slope of another place.")
    return f"After 60 steps it is {np.abs(path[-1] - bottom).max():.2g} from the bottom."


@check("Which of the seven end elsewhere when they start elsewhere?")
def start_decides(answer: Any) -> str:
    """Hold the set of names that depend on the start."""
    require(isinstance(answer, (set, list, tuple)), "A set of names is wanted, such as {'l1', 'theta2'}.")
    named = {str(name) for name in answer}
    strange = named - set(NAMES)
    require(not strange, f"There is no parameter {', '.join(sorted(strange))}; they are {', '.join(NAMES)}.")
    require(
        len(named) == len(_DEPENDS_ON_THE_START), f"You name {len(named)}; look at the table for each of the seven."
    )
    require(named == _DEPENDS_ON_THE_START, "The number is right, the names are not all.")
    return "No data move these along their common direction: the start does."


@check("The Jacobian: how tip coordinates move with each parameter")
def jacobian(answer: Callable[..., Any]) -> str:
    """Hold a Jacobian against the analytic one."""
    fit, _ = measured_arm()
    rng = np.random.default_rng(41)
    for delta in rng.normal(0, [2, 2, 2, 2, 0.05, 0.05, 0.05], (2, 7)):
        found = array(answer(*copies(delta, fit.q_cmd)), (2 * len(fit), 7), "jacobian")
        wanted = _jacobian(delta)
        by_axis = wanted.reshape(-1, 2, 7).transpose(1, 0, 2).reshape(-1, 7)
        require(
            not np.allclose(found, by_axis, atol=1e-2),
            "All x stand before all y. Here the rows go pose by pose: x, y, x, y ...",
        )
        require(not np.allclose(found, -wanted, atol=1e-2), "Its sign is turned round: it is d tip / d parameter.")
        for column, name in enumerate(NAMES):
            off = np.abs(found[:, column] - wanted[:, column]).max()
            require(off < 1e-2 * np.abs(wanted[:, column]).max(), f"The column of {name} is off by up to {off:.3g}.")
    return "Good to a hundredth, which is all that follows needs."


@check("How many of the seven can be known?")
def known(answer: Any) -> str:
    """Hold the rank."""
    found = number(answer, "known")
    require(1 <= found <= 7 and found == round(found), "A whole number from 1 to 7 is wanted.")
    require(found < 7, "Look at the singular values on a logarithmic axis: are they all of one kind?")
    require(found >= 6, "The smaller ones are small, but compare them with the noise and with the smallest.")
    return "One motion of the parameters changes nothing that a camera could see."


@check("The direction that no data tell")
def silent(answer: Any) -> str:
    """Hold a direction against the Jacobian's null space."""
    direction = array(answer, (7,), "silent")
    length = float(np.linalg.norm(direction))
    require(length > 0, "A direction of length zero is none.")
    moved = np.linalg.norm(_jacobian(np.zeros(7)) @ direction) / length
    require(moved < _SILENT, f"Along yours the tips still move, by {moved:.3g} a unit step over all poses.")
    return "It turns the last link's zero one way and its two lengths the other way."


@check("The calibrated arm predicts the line that it has not seen")
def calibrated(answer: Any) -> str:
    """Hold an estimate against poses that it did not see."""
    delta = array(answer, (7,), "estimate")
    _, line = measured_arm()
    require(
        bool(np.abs(delta[4:]).max() < 1.0),
        "A joint's zero is off by more than a radian in yours; mm and rad may be exchanged, or it diverged.",
    )
    miss = _tip(delta, line.q_cmd) - line.tip_mm
    mean = float(np.linalg.norm(miss, axis=1).mean())
    drawn = float(np.linalg.norm(_tip(np.zeros(7), line.q_cmd) - line.tip_mm, axis=1).mean())
    require(mean < drawn, f"On the line it misses by {mean:.3g} mm on average, the drawing by {drawn:.3g} mm.")
    require(
        mean < _HELD_OUT_MM,
        f"On the line it still misses by {mean:.3g} mm on average (drawing: {drawn:.3g}); the noise is about 0.2.",
    )
    return f"{drawn:.2f} mm with the drawing, {mean:.2f} mm with yours: what is left is the camera's noise."


@check("How well is l1 known? Its standard deviation, mm")
def interval(answer: Any) -> str:
    """Hold a standard deviation against the covariance of the six that can be known."""
    found = number(answer, "std_l1_mm")
    require(found > 0, "A standard deviation is positive.")
    fit, _ = measured_arm()
    J = _jacobian(_best())
    left = _misses(_best()).ravel()
    covariance = np.linalg.pinv(J.T @ J, rcond=1e-9) * (left @ left) / (len(left) - 6)
    wanted = float(np.sqrt(covariance[0, 0]))
    require(found < 100 * wanted, "Far too wide: JᵀJ cannot be inverted as it stands. Think of the silent direction.")
    require(
        not np.isclose(found, wanted**2, rtol=0.1) or np.isclose(wanted, wanted**2, rtol=0.1),
        "That is the variance.",
    )
    require(abs(found - wanted) < 0.2 * wanted, f"Yours is {found / wanted:.2g} times what the residuals say.")
    return f"{len(fit)} poses tell l1 to ±{1.96 * found:.2g} mm in 95 of 100 repetitions."


def _tip(delta: Array, q: Array) -> Array:
    return forward(nominal_arm(), q, Deviation(delta[:4], delta[4:]))[:, :2]


def _misses(delta: Array) -> Array:
    fit, _ = measured_arm()
    return _tip(delta, fit.q_cmd) - fit.tip_mm


def _jacobian(delta: Array) -> Array:
    fit, _ = measured_arm()
    by_length, by_joint = forward_jacobian(nominal_arm(), fit.q_cmd, Deviation(delta[:4], delta[4:]))
    return np.concatenate([by_length[:, -1], by_joint[:, -1]], axis=-1).reshape(-1, 7)


def _best() -> Array:
    delta = np.zeros(7)
    for _ in range(20):
        delta = delta - np.linalg.lstsq(_jacobian(delta), _misses(delta).ravel(), rcond=1e-9)[0]
    return delta
