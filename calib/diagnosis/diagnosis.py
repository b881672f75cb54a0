"""The whole of a diagnosis: gate, search, ties, verdict, uncertainty, held-out gain."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from armtwin.calib.diagnosis.crossed import LEFT_IN
from armtwin.calib.diagnosis.explanation import Cause, Explanation
from armtwin.calib.diagnosis.fit import degrees_of_freedom
from armtwin.calib.diagnosis.geometry import GeometryReport, geometry_report
from armtwin.calib.diagnosis.holdout import HeldOut, every_fourth, held_out_gain, held_out_rows, held_out_trend
from armtwin.calib.diagnosis.problem import Problem, problem_of
from armtwin.calib.diagnosis.repairs import cost_unrepaired
from armtwin.calib.diagnosis.search import search
from armtwin.calib.diagnosis.significance import loud_from, of_the_grain
from armtwin.calib.diagnosis.structure import Trend, louder_than_noise, trends, typical_misfit
from armtwin.calib.diagnosis.uncertainty import uncertainty
from armtwin.calib.diagnosis.vanished import vanished
from armtwin.models.catalogue.predict import Active
from armtwin.models.errors import RecordingError
from armtwin.models.recordings.part import shortened
from armtwin.models.recordings.recording import Recording
from armtwin.models.tabular import html_table

Array = NDArray[np.float64]
Bool = NDArray[np.bool_]
Verdict = Literal["none", "named", "ambiguous", "unknown"]

# What hides well below the declared noise may follow anything: the declaration says that it does not matter.
_HEARD = 0.95
# No term has exactly the world's form, but a model that leaves more than this share of what there was to explain has
# not found the cause; nor has one that leaves a lesser share that follows something, or a still lesser one, well above
# the noise, that plainly does.
LEFT_SHARE = 0.1
FOLLOWING_SHARE = 0.035
PLAIN_SHARE = 0.025
PLAIN_NOISE = 2.0
PLAIN_TREND = 0.3
# Values beyond the number of parameters without which nothing can be decided.
_SPARE_VALUES = 6


@dataclass(frozen=True, eq=False)
class NamedCause:
    """A cause with its parameters (k,) and their standard deviations (k,)."""

    active: Active
    names: tuple[str, ...]
    std: Array
    p_value: float
    explained_percent: float
    equivalents: tuple[Active, ...]


@dataclass(frozen=True, eq=False)
class Diagnosis:
    """What a recording says of its twin.

    Attributes:
        verdict: none, named, ambiguous or unknown.
        causes: named ones, most explaining first; empty for none and unknown.
        suspects: for the verdict unknown, what explains most although not enough.
        only_held_out: the verdict is unknown because only the held-out poses show something; the suspects are then what
            is found where every fourth pose is held out instead, and no estimate has changed by it.
        geometry, held_out: calibrated geometry; errors before and after on unseen poses.
        trends_before, trends_after: what the remainder follows, for the geometric and for the extended twin.
        unexplained_rms_mm: of the extended twin on the poses that it was fitted to.
        problem, explanation, fit_rows: for reports and experiments.

    """

    verdict: Verdict
    causes: tuple[NamedCause, ...]
    suspects: tuple[NamedCause, ...]
    only_held_out: bool
    geometry: GeometryReport
    held_out: HeldOut
    trends_before: tuple[Trend, ...]
    trends_after: tuple[Trend, ...]
    unexplained_rms_mm: float
    problem: Problem
    explanation: Explanation
    fit_rows: Bool
    held_rows: Bool

    def columns(self) -> dict[str, Any]:
        """Return a row a parameter of each cause: effect, joint, marker, parameter, value, standard deviation."""
        rows = [
            (cause.active, name, value, std)
            for cause in self.causes
            for name, value, std in zip(cause.names, cause.active.values, cause.std, strict=False)
        ]
        return {
            "effect": [active.effect.name for active, *_ in rows],
            "joint": [active.site.joint for active, *_ in rows],
            "marker": [active.site.marker for active, *_ in rows],
            "parameter": [name for _, name, *_ in rows],
            "value": [float(value) for *_, value, _ in rows],
            "std": [float(std) for *_, std in rows],
        }

    def _repr_html_(self) -> str:
        held = self.held_out
        errors = f"{held.before_rms_mm:.3g} → {held.after_rms_mm:.3g} mm on held-out poses"
        return html_table(f"Diagnosis: {self.verdict}; {errors}", self.columns())


def diagnose(recording: Recording, progress: Callable[[str], None] = lambda _: None) -> Diagnosis:
    """Diagnose a recording, of one of very many poses a fair part.

    Raises `RecordingError` where it cannot decide anything, and says what is missing.
    """
    recording = shortened(recording)
    problem = problem_of(recording)
    held_rows, names, words = held_out_rows(recording)
    fit_rows = ~held_rows
    check_decidable(problem, fit_rows)
    progress("fitting the geometry")
    noise = recording.pixel_noise_px if problem.is_pixels else None
    explanation = search(problem, fit_rows, noise, progress)
    data, final = explanation.data, explanation.final
    progress("measuring the gain on held-out poses")
    before = tuple(trends(data, explanation.geometric))
    after = tuple(trends(data, final))
    causes, covariance = _causes(explanation)
    verdict = _verdict(explanation, after, causes)
    if verdict == "unknown" and not after:
        after = (louder_than_noise(data, final),)
    suspects = causes if verdict == "unknown" else ()
    only_held_out = held_out_trend(problem, explanation, held_rows) if verdict == "none" else None
    if only_held_out is not None:
        progress("looking at what only the held-out poses show")
        verdict, after = "unknown", (only_held_out,)
        suspects, _ = _causes(search(problem, ~every_fourth(len(recording)), noise, progress))
    gone = vanished(problem, problem.predict(final.g, final.effects)) if verdict == "none" else None
    if gone is not None:
        verdict, after = "unknown", (gone,)
    held_out = held_out_gain(problem, explanation, held_rows, names, words)
    return Diagnosis(
        verdict=verdict,
        causes=() if verdict == "unknown" else causes,
        suspects=suspects,
        only_held_out=only_held_out is not None,
        geometry=geometry_report(data, final, covariance),
        held_out=held_out,
        trends_before=before,
        trends_after=after,
        unexplained_rms_mm=_rms_mm(explanation, held_out),
        problem=problem,
        explanation=explanation,
        fit_rows=fit_rows,
        held_rows=held_rows if held_rows.any() else fit_rows,
    )


def check_decidable(problem: Problem, rows: Bool) -> None:
    """Raise `RecordingError` where there are too few poses, or nothing that moves is seen or commanded."""
    if problem.channels == ("a",):
        raise RecordingError("samples.csv: only marker A is ever seen, and it does not move; another marker is wanted")
    seen = np.isfinite(problem.observed).all(axis=-1) & rows[:, None]
    values = int(seen.sum()) * problem.observed.shape[-1]
    if rows.all():  # of few poses none is kept back, but a fold of them is left out in turn
        values = int(values * LEFT_IN)
    wanted = len(problem.nominal) + _SPARE_VALUES
    if values < wanted:
        each = max(problem.observed.shape[1] * problem.observed.shape[-1], 1)
        missing = int(np.ceil((wanted - values) / each))
        raise RecordingError(
            f"samples.csv: too short to decide: {int(seen.any(axis=1).sum())} poses to fit with {values} measured "
            f"values, {wanted} are wanted; add at least {missing} poses"
        )
    q = problem.context.q_cmd[rows]
    still = [f"theta{joint + 1}_cmd_rad" for joint in range(q.shape[1]) if np.ptp(q[:, joint]) < 1e-6]
    if len(still) == q.shape[1]:
        raise RecordingError(f"samples.csv: {', '.join(still)} never change; nothing can be told of an arm at rest")


def _causes(explanation: Explanation) -> tuple[tuple[NamedCause, ...], Array]:
    """Return the causes with their standard deviations, and the covariance of the geometry beside them."""
    spread = uncertainty(explanation.data, explanation.final)
    fitted = tuple(_named(explanation, cause, spread.effects_std) for cause in explanation.causes)
    return (*fitted, *(_found(active, explanation) for active in explanation.found)), spread.covariance


def _verdict(explanation: Explanation, after: tuple[Trend, ...], causes: tuple[NamedCause, ...]) -> Verdict:
    reduced = _without_worst(explanation.final.misfit, explanation)
    loud = loud_from(explanation.data, explanation.final)
    if not explanation.causes:
        follows = bool(after) and reduced > _HEARD and not of_the_grain(explanation.data, explanation.final)
        if reduced > loud or follows:
            return "unknown"
        return "named" if causes else "none"
    before = _without_worst(explanation.geometric.misfit, explanation)
    left = max(reduced - 1.0, 0.0) / max(before - 1.0, 1e-9)
    plain = left > PLAIN_SHARE and reduced > PLAIN_NOISE and any(trend.share > PLAIN_TREND for trend in after)
    following = left > FOLLOWING_SHARE and bool(after)
    if plain or following or (left > LEFT_SHARE and reduced > loud):
        return "unknown"
    return "ambiguous" if any(cause.equivalents for cause in causes) else "named"


def _without_worst(misfit: Array, explanation: Explanation) -> float:
    """Misfit to a value, of all poses but the worst, over what noise alone would leave of as many."""
    data = explanation.data
    scale = degrees_of_freedom(data, explanation.final) / data.n_values
    return typical_misfit(misfit, data.counts, data.problem.observed.shape[-1]) / scale


def _named(explanation: Explanation, cause: Cause, stds: tuple[Array, ...]) -> NamedCause:
    data, final = explanation.data, explanation.final
    index = [active.key for active in final.effects].index(cause.active.key)
    parameters = cause.active.effect.parameters(data.problem.context, cause.active.site)
    return NamedCause(
        active=cause.active,
        names=tuple(parameter.name for parameter in parameters),
        std=stds[index],
        p_value=cause.p_value,
        explained_percent=100.0 * cause.explained_share,
        equivalents=cause.equivalents,
    )


def _found(active: Active, explanation: Explanation) -> NamedCause:
    """Return a cause of single samples: what its points would cost if they were taken as they came."""
    data, final = explanation.data, explanation.final
    cost, points = cost_unrepaired(explanation.untouched, data, final, active)
    d = data.problem.observed.shape[-1]
    p_value = float(min(1.0, len(final.misfit) * stats.chi2.sf(cost, d * max(points, 1))))
    return NamedCause(active, (), np.zeros(0), p_value, 100.0 * cost / (cost + explanation.excess), ())


def _rms_mm(explanation: Explanation, held_out: HeldOut) -> float:
    data = explanation.data
    per_noise = held_out.noise_floor_mm / np.sqrt(data.problem.observed.shape[-1])
    points = max(int(data.counts.sum()), 1)
    return float(np.sqrt(explanation.final.misfit.sum() / points) * per_noise)
