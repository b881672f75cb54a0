"""The gain, measured once, on poses that no step of the search has seen."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from armtwin.calib.diagnosis.crossed import FEW_POSES, crossed_predictions
from armtwin.calib.diagnosis.explanation import Explanation
from armtwin.calib.diagnosis.fit import Data, Fit, degrees_of_freedom, fit
from armtwin.calib.diagnosis.problem import Problem
from armtwin.calib.diagnosis.repairs import find, repair
from armtwin.calib.diagnosis.significance import loud_from
from armtwin.calib.diagnosis.structure import Trend, typical_misfit
from armtwin.models.catalogue.predict import Active
from armtwin.models.errors import RecordingError
from armtwin.models.recordings.recording import Recording

Array = NDArray[np.float64]
Bool = NDArray[np.bool_]

_BOOTSTRAPS = 2000
# Poses that follow one another share their errors; they are resampled together.
_BLOCK = 5
# Every n-th pose is kept back where there are too few trajectories to keep a whole one.
_EVERY = 4
# Few held-out poses may be loud by chance: this many standard deviations of a mean of squares are allowed beside.
_CHANCE = 4.0


@dataclass(frozen=True, eq=False)
class HeldOut:
    """Errors on held-out poses, mm in the robot's plane (for joint angles: mm at the tip of the stretched arm)."""

    trajectories: tuple[str, ...]
    description: str
    n_poses: int
    nominal_rms_mm: float
    before_rms_mm: float
    after_rms_mm: float
    before_median_mm: float
    after_median_mm: float
    noise_floor_mm: float
    gain_percent: float
    gain_ci95_percent: tuple[float, float]

    @property
    def bears_out(self) -> bool:
        """Whether the held-out poses show a gain: its interval lies above nothing."""
        return self.gain_ci95_percent[0] > 0.0


def held_out_rows(recording: Recording) -> tuple[Bool, tuple[str, ...], str]:
    """Return the rows (N,) to keep back, their trajectories, and in words how they were chosen.

    Raises `RecordingError` where the recording holds out all that it has.
    """
    names = list(dict.fromkeys(str(name) for name in recording.trajectory))
    if recording.held_out:
        kept = tuple(recording.held_out)
        if set(names) <= set(kept):
            raise RecordingError(
                f"recording.json: held_out names every trajectory ({', '.join(names)}); leave some to fit to"
            )
        return np.isin(recording.trajectory, kept), kept, "the trajectories that the recording holds out"
    if len(recording) < FEW_POSES:
        return np.zeros(len(recording), dtype=bool), (), "every pose in turn, predicted from the others: there are few"
    if len(names) >= 4:
        return recording.trajectory == names[-1], (names[-1],), "the last trajectory"
    words = f"every {_EVERY}th pose, there being too few trajectories to hold a whole one out"
    return every_fourth(len(recording)), (), words


def every_fourth(n_poses: int) -> Bool:
    """Return the rows (N,) to keep back where whole trajectories cannot be."""
    return np.arange(n_poses) % _EVERY == _EVERY // 2


def held_out_trend(problem: Problem, explanation: Explanation, rows: Bool) -> Trend | None:
    """Return how much the held-out rows show that the others do not, or None where they agree.

    The model is refitted to all rows, so that where the geometry was poorly known all poses together make up for it;
    what it then still misses most held-out poses by is neither geometry nor noise. Nothing is chosen by this.
    """
    data, final = explanation.data, explanation.final
    held = _seen(problem) & rows[:, None]
    if not held.any():
        return None
    observed = np.where(rows[:, None, None], problem.observed, data.problem.observed)
    whole = replace(data, problem=replace(data.problem, observed=observed), counts=data.counts | held)
    refitted = fit(whole, final.g, final.effects)
    d = observed.shape[-1]
    most = typical_misfit(refitted.misfit, held, d)
    others = max(1.0, float(final.misfit.sum()) / degrees_of_freedom(data, final))
    values = d * int(held.sum())
    if most / others < loud_from(data, final) + _CHANCE * np.sqrt(2.0 / values):
        return None
    return Trend("the poses held out", 1.0 - others / most, float(stats.chi2.sf(values * most / others, values)))


def held_out_gain(
    problem: Problem, explanation: Explanation, rows: Bool, names: tuple[str, ...], words: str
) -> HeldOut:
    """Measure the errors of the drawing, the calibrated and the extended twin on the held-out rows."""
    data, final = explanation.data, explanation.final
    if rows.any():
        nominal, before, after = _kept_back(problem, explanation, rows)
    else:
        observed, seen = data.problem.observed, data.counts
        nominal = _errors(problem, observed, seen, problem.predict(problem.nominal, ()))
        before, after = (_errors(data.problem, observed, seen, p) for p in crossed_predictions(data, explanation))
    floor = data.noise * _mm_per_unit(problem, final.g) * np.sqrt(problem.observed.shape[-1])
    gain, interval = _gain(before, after)
    return HeldOut(
        trajectories=names,
        description=words,
        n_poses=int(rows.sum()) or int(data.counts.any(axis=1).sum()),
        nominal_rms_mm=_rms(nominal),
        before_rms_mm=_rms(before),
        after_rms_mm=_rms(after),
        before_median_mm=_median(before),
        after_median_mm=_median(after),
        noise_floor_mm=float(floor),
        gain_percent=gain,
        gain_ci95_percent=interval,
    )


def _kept_back(problem: Problem, explanation: Explanation, rows: Bool) -> tuple[Array, Array, Array]:
    """Three (N, M) errors on rows that no step of the search has seen, mm: drawing, calibrated and extended twin."""
    data, final = explanation.data, explanation.final
    whole = replace(
        data, problem=replace(data.problem, observed=problem.observed), counts=_seen(problem) & rows[:, None]
    )
    everything = replace(whole, counts=data.counts | whole.counts)
    effects = _found_here_too(everything, final)
    repaired = repair(whole, replace(final, effects=effects))
    observed, seen = repaired.data.problem.observed, repaired.data.counts
    return (
        _errors(problem, observed, seen, problem.predict(problem.nominal, ())),
        _errors(data.problem, observed, seen, data.problem.predict(explanation.geometric.g, ())),
        _errors(data.problem, observed, seen, data.problem.predict(final.g, effects)),
    )


def in_millimetres(problem: Problem, g: Array, residual: Array) -> Array:
    """(N, M, 2) residual in the robot's plane, x and y in mm, of one in pixels; for angles (N, M, 1) mm at the tip."""
    if not problem.is_pixels:
        return residual * _mm_per_unit(problem, g)
    by_x, by_y = problem.pixels_by_plane(g)
    J = np.stack([by_x, by_y], axis=-1)
    plane = np.linalg.solve(J, np.nan_to_num(residual)[..., None])[..., 0]
    return np.where(np.isfinite(residual), plane, np.nan)


def _errors(problem: Problem, observed: Array, seen: Bool, predicted: Array) -> Array:
    """(N, M) distance of what was seen from what is predicted, mm; NaN where it does not count."""
    residual = np.where(seen[..., None], observed - predicted, np.nan)
    return np.sqrt((in_millimetres(problem, problem.nominal, residual) ** 2).sum(axis=-1))


def _found_here_too(everything: Data, final: Fit) -> tuple[Active, ...]:
    """Return the effects with the single samples of the held-out rows added, where such are among the causes.

    Which single poses were missed is seen, not predicted; finding them fits nothing. They are looked for among all
    rows, since a run of them may begin in rows that were fitted.
    """
    effects = []
    for active in final.effects:
        if active.effect.found is None:
            effects.append(active)
            continue
        bare = replace(final, effects=tuple(other for other in final.effects if other.key != active.key))
        here = [one for one in find(active.effect, everything, bare) if one.site == active.site]
        rows = np.union1d(active.values, here[0].values) if here else active.values
        effects.append(replace(active, values=rows))
    return tuple(effects)


def _seen(problem: Problem) -> Bool:
    return np.asarray(np.isfinite(problem.observed).all(axis=-1))


def _mm_per_unit(problem: Problem, g: Array) -> float:
    """Millimetres in the plane to a pixel, or at the tip of the stretched arm to a radian."""
    if not problem.is_pixels:
        return float(problem.context.arm.link_lengths_mm.sum())
    by_x, by_y = problem.pixels_by_plane(g)
    area = np.abs(by_x[..., 0] * by_y[..., 1] - by_x[..., 1] * by_y[..., 0])
    return float(1.0 / np.sqrt(np.median(area)))


def _rms(errors: Array) -> float:
    return float(np.sqrt(np.nanmean(errors**2))) if np.isfinite(errors).any() else float("nan")


def _median(errors: Array) -> float:
    return float(np.nanmedian(errors)) if np.isfinite(errors).any() else float("nan")


def _gain(before: Array, after: Array) -> tuple[float, tuple[float, float]]:
    """Percent by which the RMS fell, with a bootstrap interval over blocks of poses."""
    kept = np.isfinite(before).any(axis=1)
    b, a = np.nansum(before[kept] ** 2, axis=1), np.nansum(after[kept] ** 2, axis=1)
    if not len(b) or b.sum() == 0:
        return float("nan"), (float("nan"), float("nan"))
    starts = np.arange(0, len(b), _BLOCK)
    block_b, block_a = np.add.reduceat(b, starts), np.add.reduceat(a, starts)
    draws = np.random.default_rng(0).integers(0, len(starts), (_BOOTSTRAPS, len(starts)))
    ratios = np.sqrt(block_a[draws].sum(axis=1) / np.maximum(block_b[draws].sum(axis=1), 1e-300))
    low, high = np.percentile(100.0 * (1.0 - ratios), [2.5, 97.5])
    return 100.0 * (1.0 - float(np.sqrt(a.sum() / b.sum()))), (float(low), float(high))
