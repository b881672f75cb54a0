"""What the remainder of a moving arm still follows: time, its command, its speed, the side it came from."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.stats import f as f_distribution

from armtwin.calib.motion.diagnosis import MotionDiagnosis
from armtwin.calib.motion.series import memory_rows

Array = NDArray[np.float64]

_BINS = 12
_LEVEL = 1e-3
# What of a remainder's squares a curve has to take away to be told.
_SHARE = 0.1


def follows(found: MotionDiagnosis) -> list[str]:
    """List what the remainder follows, in words: 'joint 3 over its angle', the plainest first."""
    told: list[tuple[float, str]] = []
    for model in found.arm.joints:
        series = found.problem.series[model.joint]
        used = series.used
        e = model.fit.e[used]
        if np.sqrt(np.mean(e**2)) < 1.2 * model.noise_rad:
            continue
        speed = np.gradient(model.fit.e + series.measured, series.time_s)[used]
        for name, over in (
            ("time", series.time_s[used]),
            ("its angle", series.measured[used]),
            ("its speed", speed),
            ("its direction", np.sign(np.where(np.abs(speed) > 0.02, speed, 0.0))),
            ("its load", series.load_nm[used]),
        ):
            share = _explained(e, over, memory_rows(e))
            if share > _SHARE:
                told.append((share, f"joint {model.joint + 1} over {name}"))
    return [text for _, text in sorted(told, reverse=True)[:8]]


def _explained(e: Array, over: Array, memory: int) -> float:
    """Return the share of the squares that the mean over bins takes away, 0 where chance does it as well."""
    if np.ptp(over) == 0.0:
        return 0.0
    edges = np.unique(np.quantile(over, np.linspace(0, 1, _BINS + 1)))
    if len(edges) < 3:
        edges = np.unique(over)
        number = np.searchsorted(edges, over)
    else:
        number = np.clip(np.searchsorted(edges, over, side="right") - 1, 0, len(edges) - 2)
    count = np.bincount(number)
    means = np.bincount(number, e) / np.maximum(count, 1)
    total, left = float(((e - e.mean()) ** 2).sum()), float(((e - means[number]) ** 2).sum())
    n, k = len(e) / memory, int((count > 0).sum())
    if k < 2 or n < 2 * k or left <= 0.0:
        return 0.0
    ratio = (total - left) / (k - 1) / (left / (n - k))
    return 1.0 - left / total if f_distribution.sf(ratio, k - 1, n - k) < _LEVEL else 0.0
