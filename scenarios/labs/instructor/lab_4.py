"""Lab 4: calibration, and what cannot be known.

**Goals.** The student writes a cost, a descent, a Jacobian and a Gauss–Newton fit with his own hands; sees that a
descent ends where it started along a direction that no data tell, and that this makes numbers look well known that
are not; states an interval with the right degrees of freedom; and judges a fit on poses that it has not seen.

**Before.** Lab 3, or D-H parameters from a lecture; singular values; least squares.

**Time.** 90 minutes: 10 for the cost, 20 for the descent and playing with the rate, 20 for the Jacobian and the rank,
25 for Gauss–Newton, 15 for the interval and the question.

**Where they get stuck.** *The silent direction*: the last row of Vᵀ, not the last column of U. *Gauss–Newton
diverges*: the sign of the step, or solving with a plain inverse. *The interval*: JᵀJ is singular; `pinv` with a
sensible `rcond`, or six of the seven columns. *Degrees of freedom*: 2N − 6, not 2N − 7, since six numbers are fitted;
the check lets both pass, they differ by half a percent.

**The question.** The spread is small because all ten repetitions start Algorithm 1 at the same vector: the descent
never moves along the silent direction, so Δl4, Δl5 and Δθ3 keep what the start gave them along it. Turning θ3's zero
by ε and (l4, l5) by −ε is the same motion of F for every pose. It takes a marker elsewhere on the last link (at E,
where l5 begins), or a ruler on l4 and l5, or a measured orientation of the last link.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from armtwin.scenarios.labs.material.calibration import DRAWN_MM, measured_arm

Array = NDArray[np.float64]


def forward(delta: Array, q: Array) -> Array:
    """Return the notebook's own kinematics."""
    l1, l2, l4, l5 = np.array(DRAWN_MM) + delta[:4]
    a = np.cumsum(q + delta[4:] + np.pi / 2, axis=1)
    z = l1 * np.exp(1j * a[:, 0]) + l2 * np.exp(1j * a[:, 1]) + (l4 - 1j * l5) * np.exp(1j * a[:, 2])
    return np.stack([z.real, z.imag], axis=-1)


def cost(delta: Array, q: Array, tip_mm: Array) -> float:
    """Average the squared distances."""
    return float(((forward(delta, q) - tip_mm) ** 2).sum(axis=1).mean())


def descend(slope: Callable[[Array], Array], start: Array, rate: float, steps: int) -> Array:
    """Go against the slope."""
    path = [np.asarray(start, dtype=float)]
    for _ in range(steps):
        path.append(path[-1] - rate * slope(path[-1]))
    return np.array(path)


def jacobian(delta: Array, q: Array) -> Array:
    """Take central differences."""
    h = 1e-5
    columns = [(forward(delta + h * e, q) - forward(delta - h * e, q)).ravel() / (2 * h) for e in np.eye(7)]
    return np.stack(columns, axis=-1)


def fit(q: Array, tip_mm: Array) -> Array:
    """Run Gauss-Newton without a step along what cannot be known."""
    delta = np.zeros(7)
    for _ in range(20):
        miss = (forward(delta, q) - tip_mm).ravel()
        delta = delta - np.linalg.lstsq(jacobian(delta, q), miss, rcond=1e-6)[0]
    return delta


_CIRCLES, _ = measured_arm()
_ESTIMATE = fit(_CIRCLES.q_cmd, _CIRCLES.tip_mm)
_J = jacobian(_ESTIMATE, _CIRCLES.q_cmd)
_LEFT = (forward(_ESTIMATE, _CIRCLES.q_cmd) - _CIRCLES.tip_mm).ravel()
_VARIANCE = _LEFT @ _LEFT / (len(_LEFT) - 6)
_SILENT = np.linalg.svd(jacobian(np.zeros(7), _CIRCLES.q_cmd))[2][-1]

SOLUTION: dict[str, Any] = {
    "cost": cost,
    "descend": descend,
    "start_decides": {"l4", "l5", "theta3"},
    "jacobian": jacobian,
    "known": 6,
    "silent": _SILENT,
    "estimate": _ESTIMATE,
    "std_l1_mm": float(np.sqrt(_VARIANCE * np.linalg.pinv(_J.T @ _J, rcond=1e-9)[0, 0])),
}
WRONG: dict[str, list[Any]] = {
    "cost": [lambda delta, q, tip_mm: np.sqrt(cost(delta, q, tip_mm)), lambda delta, q, tip_mm: 1 / 0],
    "descend": [lambda slope, start, rate, steps: descend(lambda x: -slope(x), start, rate, steps)],
    "start_decides": [{"l1", "l5", "theta3"}, {"l4", "l5"}],
    "jacobian": [lambda delta, q: jacobian(delta, q) * [1, 1, 1, 1, np.pi / 180, 1, 1]],
    "known": [7, "six"],
    "silent": [np.array([0.0, 0, 1, -1, 0, 0, 1])],
    "estimate": [np.zeros(7), np.zeros(6)],
    "std_l1_mm": [float(np.sqrt(np.linalg.pinv(_J.T @ _J, rcond=1e-9)[0, 0])), SOLUTION["std_l1_mm"] ** 2],
}
