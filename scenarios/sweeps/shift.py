"""By how much a predicted curve is off the trials, from all of them, wherever they were placed.

A size found in 90 of 100 that is read off a few dozen trials is known to a factor of two, since its curve's slope and
lapse have to be found along. Where power predicts the curve itself, only its place on the axis of sizes is open.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from armtwin.scenarios.power.place import PlacePower
from armtwin.scenarios.scoring.judge import label
from armtwin.scenarios.sweeps.curve import Found
from armtwin.scenarios.sweeps.trial import Row

Array = NDArray[np.float64]

# Factors that are looked at, and the share of worlds that may go otherwise than any curve says.
_MOST, _STEPS = 20.0, 241
_OTHERWISE = 0.06
_BAND = (0.05, 0.5, 0.95)


def predicted_over_found(rows: Sequence[Row], places: Sequence[PlacePower]) -> Found | None:
    """Return how many times too large the predicted sizes are: median and interval of 90 %, None without curves."""
    curves = {_label(one): _curve(one) for one in places if len(one.sizes) > 1}
    known = [row for row in rows if row["hidden"] in curves]
    if not known:
        return None
    off = np.geomspace(1.0 / _MOST, _MOST, _STEPS)
    weight = np.zeros(_STEPS)
    for row in known:
        p = (1.0 - _OTHERWISE) * curves[row["hidden"]](row["size"] * off) + 0.5 * _OTHERWISE
        weight += np.log(p if row["found"] else 1.0 - p)
    share = np.exp(weight - weight.max())
    below = np.cumsum(share) / share.sum()
    low, middle, high = (float(off[int(np.searchsorted(below, level))]) for level in _BAND)
    return Found(middle, low, high)


def _curve(one: PlacePower) -> Callable[[Array], Array]:
    sizes, found = np.log(one.sizes), np.array(one.found)
    return lambda size: np.asarray(np.interp(np.log(size), sizes, found))


def _label(one: PlacePower) -> str:
    return label({"effect": one.effect, "joint": one.site.joint, "marker": one.site.marker})
