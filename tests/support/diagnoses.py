"""The parts of a diagnosis, made for a recording, for tests of what stands on them."""

from __future__ import annotations

import numpy as np

from armtwin.calib.diagnosis.explanation import Explanation
from armtwin.calib.diagnosis.fit import Data, Fit, excess_of, fit
from armtwin.calib.diagnosis.problem import problem_of
from armtwin.models.catalogue.predict import Active
from armtwin.models.catalogue.registry import Site, effect_named
from armtwin.models.recordings.recording import Recording


def data_of(recording: Recording, rows: np.ndarray | None = None) -> Data:
    """Return what counts of a recording: all that was seen, or of the rows (N,) only."""
    problem = problem_of(recording)
    counts = np.isfinite(problem.observed).all(axis=-1)
    noise = recording.pixel_noise_px
    assert noise is not None
    return Data(problem, counts if rows is None else counts & rows[:, None], noise)


def geometry_of(data: Data) -> Fit:
    """Return the fit of the geometry alone."""
    return fit(data, data.problem.nominal, ())


def fitted(data: Data, name: str, site: Site, *values: float) -> Fit:
    """Return the fit of the geometry and one effect that starts at these values."""
    start = geometry_of(data)
    return fit(data, start.g, (Active(effect_named(name), site, np.array(values)),))


def explanation_of(data: Data, final: Fit) -> Explanation:
    """Return the outcome of a search that ended with this model and found nothing else."""
    geometric = geometry_of(data)
    return Explanation(data, data, geometric, final, (), (), excess_of(data, geometric), excess_of(data, final), ())
