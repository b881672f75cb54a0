"""Every effect alone, fitted jointly with the geometry: how much of the misfit it explains."""

from __future__ import annotations

from dataclasses import dataclass

from armtwin.calib.diagnosis.candidates import candidate_sites, fit_candidates
from armtwin.calib.diagnosis.diagnosis import Diagnosis
from armtwin.calib.diagnosis.fit import excess_of


@dataclass(frozen=True)
class Ranked:
    """An effect at a site: share of the excess misfit that it explains; "named", "tied" or neither."""

    label: str
    explained_share: float
    score: float
    standing: str


def rank_causes(diagnosis: Diagnosis) -> list[Ranked]:
    """Return the effects that were fitted in full, by score, best first; none where there is nothing to explain."""
    explanation = diagnosis.explanation
    data, geometric, excess = explanation.data, explanation.geometric, explanation.excess
    if excess <= 0:
        return []
    named = {cause.active.key for cause in diagnosis.causes}
    tied = {other.key for cause in diagnosis.causes for other in cause.equivalents}
    ranked = []
    for candidate in fit_candidates(data, geometric, candidate_sites(data)):
        key = candidate.active.key
        share = 1.0 - min(excess_of(data, candidate.fit) / excess, 1.0)
        standing = "named" if key in named else "tied" if key in tied else ""
        ranked.append(Ranked(candidate.active.label, share, candidate.score, standing))
    return ranked
