"""Lab 5: what is still wrong.

**Goals.** The student reads residuals against order, angle and direction of approach and knows which cause shows
where; writes the F test of nested models and knows what a p-value does not say; sees a fit get better and the model
worse, and chooses a degree on poses that were not fitted.

**Before.** Residuals (Lab 4); the F distribution is given.

**Time.** 90 minutes: 35 for the five pictures, 15 for the test, 25 for the held-out error, 5 for the tool, 10 for the
question.

**Where they get stuck.** *D*: the sag of joint 1 is smooth over the joint's own angle, but not one curve of it: the
torque depends on where link 2 is as well, so draw it against link 2's angle. *C*: nobody looks at marker A, which
should not move. *The table of p-values*: E's slip makes the direction of approach significant in that recording too,
since the two halves of the recording differ: a p-value tests a model against another, not against the truth.

**The question.** Where the other joints stand still, the torque at a joint is a function of its own angle: then sag
and a curved servo make the same residuals, and no number of such poses tells them apart (as in Lab 6). Vary the other
joints, hang a known mass at the tip, or lay the arm flat.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import stats

Array = NDArray[np.float64]


def p_value(rss_small: float, k_small: int, rss_big: float, k_big: int, n: int) -> float:
    """Test nested models by F."""
    F = ((rss_small - rss_big) / (k_big - k_small)) / (rss_big / (n - k_big))
    return float(stats.f.sf(F, k_big - k_small, n - k_big))


def held_out_rms(x: Array, y: Array, fit: Array, test: Array, degree: int) -> float:
    """Fit on one set of rows and judge on another."""
    curve = np.polynomial.Polynomial.fit(x[fit], y[fit], degree)
    return float(np.sqrt(np.mean((y[test] - curve(x[test])) ** 2)))


SOLUTION: dict[str, Any] = {
    "causes": {
        "A": "servo_nonlinearity",
        "B": "backlash",
        "C": "camera_moved",
        "D": "gravity_sag",
        "E": "joint_slip",
    },
    "p_value": p_value,
    "held_out_rms": held_out_rms,
    "degree": 5,
}
WRONG: dict[str, list[Any]] = {
    "causes": [
        {**SOLUTION["causes"], "D": "servo_nonlinearity"},
        {"A": "backlash"},
        {**SOLUTION["causes"], "C": "bump"},
    ],
    "p_value": [lambda *models: 1 - p_value(*models), lambda *models: 2.0],
    "held_out_rms": [lambda x, y, fit, test, degree: held_out_rms(x, y, fit, fit, degree)],
    "degree": [16, 2, 4.5],
}
