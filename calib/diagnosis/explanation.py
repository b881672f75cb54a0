"""The outcome of a search: the causes with what each explains, and what could stand in its place."""

from __future__ import annotations

from dataclasses import dataclass

from scipy import stats

from armtwin.calib.diagnosis.acceptance import free_of
from armtwin.calib.diagnosis.candidates import CandidateModel, candidate_sites
from armtwin.calib.diagnosis.fit import Data, Fit, degrees_of_freedom, excess_of, fit
from armtwin.calib.diagnosis.repairs import Repaired, is_certain
from armtwin.calib.diagnosis.replacement import Equivalents, Ranked
from armtwin.models.catalogue.predict import Active


@dataclass(frozen=True, eq=False)
class Cause:
    """An effect of the final model, with what it explains and what could stand in its place."""

    active: Active
    p_value: float
    explained_share: float
    equivalents: tuple[Active, ...]


@dataclass(frozen=True, eq=False)
class Explanation:
    """The outcome of a search.

    Attributes:
        data: after repairs.
        untouched: as recorded.
        geometric, final: fits of the geometry alone and with all causes.
        causes: fitted ones, most explaining first.
        found: effects of single samples that were repaired or modelled.
        excess, remaining: deviance above what noise alone leaves, before and after.
        considered: scores of the last candidates that were turned down, best first.
        alone: the candidates on top of the geometry alone, and the data that they were fitted to, maybe a part.

    """

    data: Data
    untouched: Data
    geometric: Fit
    final: Fit
    causes: tuple[Cause, ...]
    found: tuple[Active, ...]
    excess: float
    remaining: float
    considered: tuple[CandidateModel, ...]
    alone: Ranked | None = None


def explanation_of(
    data: Data,
    untouched: Data,
    base: Fit,
    repaired: Repaired,
    equivalents: Equivalents,
    considered: list[CandidateModel],
    alone: Ranked | None,
) -> Explanation:
    """Return the outcome for a model, with what each of its causes explains and how surely."""
    geometric = fit(data, base.g, ())
    final = fit(data, base.g, base.effects)
    excess = excess_of(data, geometric)
    causes = []
    for active in final.effects:
        without = fit(data, base.g, tuple(other for other in base.effects if other.key != active.key))
        gain = float(without.misfit.sum() - final.misfit.sum())
        left = max(1.0, final.misfit.sum() / degrees_of_freedom(data, final))
        k = free_of(data, active)
        p_value = float(min(1.0, len(candidate_sites(data)) * stats.chi2.sf(max(gain, 0.0) / left, k)))
        share = min(gain / excess, 1.0) if excess > 0 else 0.0
        causes.append(Cause(active, p_value, share, equivalents.get(active.key, ())))
    causes.sort(key=lambda cause: -cause.explained_share)
    return Explanation(
        data=data,
        untouched=untouched,
        geometric=geometric,
        final=final,
        causes=tuple(causes),
        found=tuple(active for active in repaired.found if is_certain(untouched, final, active)),
        excess=excess,
        remaining=excess_of(data, final),
        considered=tuple(considered),
        alone=alone,
    )
