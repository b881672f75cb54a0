"""Every effect alone, fitted jointly with the geometry: how much of the misfit it explains."""

from __future__ import annotations

from dataclasses import dataclass

from armtwin.calib.diagnosis.diagnosis import Diagnosis
from armtwin.calib.diagnosis.fit import excess_of, fit


@dataclass(frozen=True)
class Ranked:
    """An effect at a site: share of the excess misfit that it explains; "named", "tied" or neither."""

    label: str
    explained_share: float
    score: float
    standing: str


def rank_causes(diagnosis: Diagnosis) -> list[Ranked]:
    """Return the effects that were fitted in full, by score, best first; none where there is nothing to explain.

    They are those of the search's first look, which of a long recording is at a part of it.
    """
    alone = diagnosis.explanation.alone
    if alone is None:
        return []
    data = alone.data
    excess = excess_of(data, fit(data, diagnosis.explanation.geometric.g, ()))
    if excess <= 0:
        return []
    named = {cause.active.key for cause in diagnosis.causes}
    tied = {other.key for cause in diagnosis.causes for other in cause.equivalents}
    ranked = []
    for candidate in alone.candidates:
        key = candidate.active.key
        share = 1.0 - min(excess_of(data, candidate.fit) / excess, 1.0)
        standing = "named" if key in named else "tied" if key in tied else ""
        ranked.append(Ranked(candidate.active.label, share, candidate.score, standing))
    return ranked
