"""Observability of a set of poses, by the indices of the calibration literature, so that a reader can compare.

O1: J. Borm and C. Menq (1991); O2: M. Driels and U. Pathre (1990); O3 and the noise amplification index O4: A. Nahvi
and J. Hollerbach (1994, 1996); O5: Y. Sun and J. Hollerbach (2008). All are of the singular values of the
identification Jacobian, here in standard deviations of the noise; larger is better.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Observability:
    """The indices of one Jacobian.

    Attributes:
        o1: geometric mean of the singular values over the root of the number of poses.
        o2: smallest over largest, the inverse condition number.
        o3: smallest.
        o4: smallest squared over largest, the noise amplification index.
        o5: one over the sum of the inverses.

    """

    o1: float
    o2: float
    o3: float
    o4: float
    o5: float


def observability(J: Array, poses: int) -> Observability:
    """Return the indices of an (M, p) Jacobian of `poses` poses; parameters that nothing shows make all of them 0."""
    s = np.linalg.svd(J, compute_uv=False)
    if len(s) < J.shape[1] or s[-1] <= s[0] * np.finfo(float).eps * max(J.shape):
        return Observability(0.0, 0.0, 0.0, 0.0, 0.0)
    return Observability(
        o1=float(np.exp(np.log(s).mean()) / np.sqrt(poses)),
        o2=float(s[-1] / s[0]),
        o3=float(s[-1]),
        o4=float(s[-1] ** 2 / s[0]),
        o5=float(1.0 / (1.0 / s).sum()),
    )
