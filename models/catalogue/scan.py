"""Grids for parameters of which the prediction is no smooth function."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from armtwin.models.catalogue.context import Context

Array = NDArray[np.float64]

_COARSE_ROWS = 40
_FINE_ROWS = 24


def since(context: Context, row: float) -> Array:
    """(N,) 1 from `row` on, 0 before."""
    return (np.arange(len(context)) >= row).astype(float)


def event_rows(context: Context, around: float | None, first: int = 1) -> list[float]:
    """Rows at which an event may have begun: spread over the recording, or close to an earlier best."""
    last = len(context) - 1
    if around is None:
        return [float(row) for row in np.unique(np.linspace(first, last, _COARSE_ROWS).round())]
    reach = max(1.0, np.ceil((last - first) / (_COARSE_ROWS - 1)))
    rows = np.linspace(around - reach, around + reach, _FINE_ROWS).round()
    return [float(row) for row in np.unique(np.clip(rows, first, last))]


def fan_about(value: float, widest: float, finest: float, count: int) -> list[float]:
    """List `value` and `count` others on either side, off by relative parts spread evenly in ratio.

    A misfit with steps at every scale has its least within a plateau of unknown width: some of these fall inside it.
    """
    parts = np.geomspace(finest, widest, count)
    return [float(v) for v in value * np.concatenate([1.0 - parts[::-1], [1.0], 1.0 + parts])]
