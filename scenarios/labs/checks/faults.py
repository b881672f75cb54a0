"""Lab 5: five faults by eye, a test, overfitting."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from armtwin.scenarios.labs.check import array, check, number, require
from armtwin.scenarios.labs.material.faults import POSSIBLE, few_rows, hidden, joint_errors

Array = NDArray[np.float64]

# Held-out errors that differ by less are the same for 24 poses.
_AS_GOOD = 1.07
_WHERE_TO_LOOK = {
    "backlash": "at each joint against its own angle, the two directions of approach in two colours",
    "camera_moved": "at marker A, which has no business moving, against the order of the poses",
    "gravity_sag": "against its own angle, and then ask whether it is a curve of that angle alone",
    "joint_slip": "at each joint against the order of the poses",
    "servo_nonlinearity": "against each joint's own angle, and ask whether both directions lie on one curve",
}


@check("Five recordings, five causes")
def causes(answer: Any) -> str:
    """Hold the named causes against the hidden ones; say where to look, not what is there."""
    truth = {name: effect for name, (effect, _) in hidden().items()}
    require(isinstance(answer, Mapping), "A dictionary is wanted, such as {'A': 'backlash', ...}.")
    said = {str(name): str(cause) for name, cause in answer.items() if cause is not None}
    missing = [name for name in truth if name not in said]
    require(not missing, f"Recordings {', '.join(missing)} have no cause yet.")
    strange = sorted(set(said.values()) - set(POSSIBLE))
    require(not strange, f"'{', '.join(strange)}' is none of the causes; they are {', '.join(POSSIBLE)}.")
    wrong = [name for name in truth if said[name] != truth[name]]
    hint = "" if not wrong else f" Look at {wrong[0]} again, {_WHERE_TO_LOOK[truth[wrong[0]]]}."
    require(not wrong, f"{len(truth) - len(wrong)} of {len(truth)} are right.{hint}")
    return "By eye. Now let a number say it."


@check("The p-value of a richer model")
def p_value(answer: Callable[..., Any]) -> str:
    """Hold an F test of nested models against SciPy's distribution."""
    for rss_small, k_small, rss_big, k_big, n in ((10.0, 2, 8.0, 4, 50), (1.0, 1, 0.99, 3, 30), (5.0, 3, 1.0, 5, 24)):
        found = number(answer(rss_small, k_small, rss_big, k_big, n), "p_value")
        F = ((rss_small - rss_big) / (k_big - k_small)) / (rss_big / (n - k_big))
        wanted = float(stats.f.sf(F, k_big - k_small, n - k_big))
        require(0 <= found <= 1, f"{found:.3g} is no probability.")
        require(not np.isclose(found, 1 - wanted) or np.isclose(wanted, 0.5), "That is how likely a smaller F is.")
        swapped = float(stats.f.sf(F, n - k_big, k_big - k_small))
        require(not np.isclose(found, swapped), "The two degrees of freedom are exchanged.")
        require(
            np.isclose(found, wanted, rtol=1e-3, atol=1e-12),
            f"With {k_small} and {k_big} parameters on {n} poses you find {found:.3g}. Mind the degrees of freedom: "
            "what a parameter gains, over what is left for each pose that is not used up.",
        )
    return "Small: so much gain is no accident. It does not say that the model is true."


@check("The error on poses that were not fitted")
def held_out(answer: Callable[..., Any]) -> str:
    """Hold a fit on one half and its error on the other against the reference."""
    seen = joint_errors("A")
    x, y, fit = seen.q_cmd[:, 0], seen.error_rad[:, 0], few_rows()
    for degree in (1, 4, 9):
        found = number(answer(x.copy(), y.copy(), fit.copy(), seen.held_out.copy(), degree), "held_out_rms")
        wanted, inside = _rms(degree)
        require(not np.isclose(found, inside, rtol=1e-3), "That is the error on the poses that were fitted.")
        require(
            np.isclose(found, wanted, rtol=1e-2), f"Degree {degree}: yours is {found / wanted:.3g} times what it is."
        )
    return "Now draw it for every degree."


@check("The degree you would use")
def degree(answer: Any) -> str:
    """Hold a degree that is as good as the best on what was held out."""
    found = number(answer, "degree")
    require(found == round(found) and 0 <= found <= 18, "A whole number from 0 to 18 is wanted.")
    errors = np.array([_rms(k)[0] for k in range(19)])
    as_good = np.flatnonzero(errors < _AS_GOOD * errors.min())
    here = errors[int(found)] / errors.min()
    why = "too stiff for what is there" if found < as_good.min() else "learns the noise of the poses it has seen"
    require(
        int(found) in as_good,
        f"On the held-out line it misses by {here:.2f} times what the best degree does: it {why}."
        if found > as_good.min()
        else f"On the held-out line it misses by {here:.2f} times what the best degree does: it is {why}.",
    )
    return "Of two that are as good, take the smaller."


def _rms(degree_: int) -> tuple[float, float]:
    """RMS on the held-out line and on the poses fitted."""
    seen = joint_errors("A")
    x, y, fit = seen.q_cmd[:, 0], seen.error_rad[:, 0], few_rows()
    curve = np.polynomial.Polynomial.fit(x[fit], y[fit], degree_)
    left = array(y - curve(x), (len(y),), "residuals")
    return float(np.sqrt(np.mean(left[seen.held_out] ** 2))), float(np.sqrt(np.mean(left[fit] ** 2)))
