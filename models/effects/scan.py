"""Grids for parameters of which the prediction is no smooth function."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from models.effects.context import Context

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


def steps_around(value: float, ratio: float, count: int = 9) -> list[float]:
    """List `count` values about `value`, evenly spaced in ratio, from value / ratio to value * ratio."""
    return [float(v) for v in value * np.geomspace(1.0 / ratio, ratio, count)]
