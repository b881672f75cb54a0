"""What an effect is shown of the residuals: to suggest where a fit begins, or to find single samples."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Bool = NDArray[np.bool_]

# Departures of joints are no larger than about this, where nothing that was seen says more.
_PRIOR_RAD = 0.03
# But no smaller than so many standard deviations of what is measured: an undeclared noise may be guessed far too high.
_PRIOR_STDS = 4.0


@dataclass(frozen=True, eq=False)
class View:
    """Observed and predicted channels (N, M, d) (pixels of markers, or measured angles), NaN where not seen.

    `scale` is the robust standard deviation of what the present model leaves; `replay` tells what the model predicts
    for other commands (N, n).
    """

    observed: Array
    predicted: Array
    scale: float
    replay: Callable[[Array], Array] | None = None

    def misfit(self, observed: Array, predicted: Array) -> Array:
        """(...,) length of the residual in units of `scale`, NaN where not seen."""
        out: Array = np.linalg.norm(observed - predicted, axis=-1) / self.scale
        return out


@dataclass(frozen=True, eq=False)
class Evidence:
    """What a residual says of the joint angles: to add dq (N, n) changes the deviance by -2 pull dq + dq stiffness dq.

    `pull` is (N, n) per rad, `stiffness` (N, n, n) per rad^2; `commands` (N, n) are what the present model sends, rad;
    `grain_rad` is the step on which readings lie, 0 without.
    """

    pull: Array
    stiffness: Array
    commands: Array
    grain_rad: float = 0.0

    def departures(self, joint: int) -> tuple[Array, Array]:
        """(N,) departures, rad, that the residual shows of joint `joint` (from 0), and their weights, 1/rad^2.

        Where the markers that are seen do not tell the joints apart, all are taken to share the departure.
        """
        own = self.stiffness[:, joint, joint]
        measured = 1.0 / float(np.sqrt(np.median(own[own > 0]))) if (own > 0).any() else 0.0
        precision = 1.0 / max(_PRIOR_RAD, _PRIOR_STDS * measured) ** 2
        inverse = np.linalg.inv(self.stiffness + np.eye(self.pull.shape[1]) * precision)
        shown = np.einsum("nk,nk->n", inverse[:, joint], self.pull)
        weights = np.maximum(1.0 / inverse[:, joint, joint] - precision, 0.0)
        return shown, np.where(self.stiffness[:, joint, joint] > 0, weights, 0.0)

    def change(self, dq: Array) -> Array:
        """(S,) change of the deviance by each of S departures dq (S, N, n)."""
        linear = np.einsum("nj,snj->s", self.pull, dq)
        out: Array = np.einsum("snj,njk,snk->s", dq, self.stiffness, dq, optimize=True) - 2.0 * linear
        return out


@dataclass(frozen=True, eq=False)
class Sightings:
    """Observed channels (N, M, d), and which of them (N, M) count."""

    observed: Array
    counts: Bool

    def differ(self, other: Sightings) -> Bool:
        """(N, M) sightings that are not the same in `other`, or count in one of the two alone."""
        moved = (self.observed != other.observed).any(axis=-1)
        return np.asarray((self.counts != other.counts) | (self.counts & moved))
