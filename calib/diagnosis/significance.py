"""How much more than the noise is more than chance: the levels of the tests, and what the noise itself is worth."""

from __future__ import annotations

import numpy as np
from scipy import stats

from armtwin.calib.diagnosis.fit import Data, Fit, degrees_of_freedom
from armtwin.calib.diagnosis.noise import channel_noise

# Family-wise level of the tests, over every site and start of the catalogue (Bonferroni, the first step of Holm).
LEVEL = 1e-3
# A remainder this many times the noise's variance is no noise, whatever it follows.
LOUD = 1.5
# Rounding takes off half a step at most, 1.73 standard deviations of a uniform one: below it, noise is the steps'.
_AT_THE_GRAIN = 1.8
# Half a step and a little for what the model is off, in standard deviations of a uniform step.
_HALF_A_STEP = 1.2 * 0.5 * np.sqrt(12.0)
# Second differences of white noise share values: a mean of n of their squares is worth n / 1.94 independent ones
# (1 + 2 (rho_1^2 + rho_2^2), rho_1 = -2/3, rho_2 = 1/6).
_SHARED = 1.0 + 2.0 * ((2.0 / 3.0) ** 2 + (1.0 / 6.0) ** 2)


def at_the_grain(data: Data) -> bool:
    """Whether the noise is what the steps of the readings leave."""
    return data.noise <= _AT_THE_GRAIN * data.problem.grain_std


def of_the_grain(data: Data, model: Fit) -> bool:
    """Whether what a model leaves may be the steps of the readings alone.

    Rounding is a function of the angle: it repeats where the arm comes back, and any curve with teeth explains it.
    """
    if not at_the_grain(data):
        return False
    within = np.abs(model.residual[data.counts]) <= _HALF_A_STEP * data.problem.grain_std
    usual = float(model.misfit.sum()) < stats.chi2.isf(LEVEL, degrees_of_freedom(data, model))
    return usual or bool(within.all())


def loud_from(data: Data, model: Fit) -> float:
    """Return from how many times the noise's variance on a remainder is no chance.

    An undeclared noise is an estimate from second differences of the same values: of a few it is rough, and where the
    channels (markers, encoders) are not alike it is that of the quietest.
    """
    if data.declared:
        return LOUD
    own = np.array([channel_noise(data.problem, model.residual, c) for c in range(data.problem.observed.shape[1])])
    weights = np.where(np.isfinite(own), data.counts.sum(axis=0), 0.0)
    unlike = float(weights @ np.maximum(np.nan_to_num(own) / data.noise, 1.0) ** 2 / max(weights.sum(), 1.0))
    free = degrees_of_freedom(data, model)
    worth = max((data.n_values - 2.0 * data.problem.observed.shape[1]) / _SHARED, 1.0)
    return unlike * float(np.maximum(LOUD, stats.f.isf(LEVEL, free, worth)))
