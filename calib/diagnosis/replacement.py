"""Steps back: every cause is taken out once, and looked for anew or replaced by one that explains its part better."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from armtwin.calib.diagnosis.candidates import CandidateModel, candidate_sites, candidates, fit_candidates, fit_without
from armtwin.calib.diagnosis.fit import Data, Fit, excess_of
from armtwin.calib.diagnosis.repairs import refound
from armtwin.calib.diagnosis.ties import tied, widest_tie
from armtwin.models.catalogue.predict import Active
from armtwin.models.catalogue.registry import Effect, Site

Key = tuple[str, int | None, str | None]
Equivalents = dict[Key, tuple[Active, ...]]

_MOST_ATTEMPTS = 4
# Of more ties than these the best are listed; the rest is as good as unknown.
MOST_EQUIVALENTS = 2
# A deviance that is off by less is the same.
_NO_DIFFERENCE = 1.0


@dataclass(frozen=True, eq=False)
class Ranked:
    """All candidates on top of the geometry alone, and the data that they were fitted to."""

    data: Data
    candidates: Sequence[CandidateModel]

    def holds_for(self, data: Data, geometric: Fit) -> bool:
        """Whether fitting them anew would tell nothing else.

        What was repaired is the same, and the links that the terms know since are so nearly the same that no deviance
        could change by as much as one: by no larger a share of it than the links did.
        """
        return self.is_of(data) and self._changed(data) * excess_of(data, geometric) < _NO_DIFFERENCE

    def is_of(self, data: Data) -> bool:
        """Whether they were fitted to these data, but for the links that the terms know since."""
        same = data.noise == self.data.noise and np.array_equal(data.counts, self.data.counts)
        return same and np.array_equal(data.problem.observed, self.data.problem.observed, equal_nan=True)

    def within_reach(self, data: Data, geometric: Fit) -> list[tuple[Effect, Site]]:
        """List the fitted effects and sites that may tie with the best once fitted with the links of `data`."""
        if not self.candidates:
            return []
        excess, best = excess_of(data, geometric), self.candidates[0]
        most = 2.0 * self._changed(data) * excess + widest_tie(excess, excess_of(self.data, best.fit))
        near = [one.active for one in self.candidates if one.score < best.score + most]
        return [(active.effect, active.site) for active in near if active.effect.is_fitted]

    def _changed(self, data: Data) -> float:
        before, now = self.data.problem.context.links, data.problem.context.links
        return float(np.abs(now - before).max() / max(float(np.abs(before).max()), 1e-12))


def settle(
    data: Data, base: Fit, progress: Callable[[str], None], known: Ranked | None = None
) -> tuple[Fit, Equivalents]:
    """Return the model in which every cause is the simplest of those that explain its part best, and their ties.

    `known` are the candidates on top of the geometry alone, where they were fitted before.
    """
    equivalents: Equivalents = {}
    for attempt in range(_MOST_ATTEMPTS):
        replaced = None
        equivalents = {}
        for active in base.effects:
            progress(f"trying others in the place of {active.label}")
            ties = _ties(data, base, active, known)
            simplest = min(ties, key=lambda candidate: _order(data, candidate))
            if simplest.active.key != active.key and attempt < _MOST_ATTEMPTS - 1:
                replaced = simplest.fit
                break
            others = [candidate.active for candidate in ties if candidate.active.key != active.key]
            equivalents[active.key] = tuple(others[:MOST_EQUIVALENTS])
        if replaced is None:
            break
        base = replaced
    return base, equivalents


def rescanned(data: Data, base: Fit) -> Fit:
    """Return the model with the scanned parameters of all but its last effect looked for anew, now that it is there."""
    return _scanned_anew(data, base, base.effects[:-1])


def rescanned_all(data: Data, base: Fit) -> Fit:
    """Return the model with all scanned parameters looked for anew."""
    return _scanned_anew(data, base, base.effects)


def _scanned_anew(data: Data, base: Fit, effects: Sequence[Active]) -> Fit:
    for active in effects:
        parameters = active.effect.parameters(data.problem.context, active.site)
        if not any(parameter.scanned for parameter in parameters):
            continue
        for candidate in fit_candidates(data, fit_without(data, base, active), [(active.effect, active.site)]):
            if candidate.fit.deviance < base.deviance:
                base = candidate.fit
    return refound(data, base)


def _order(data: Data, candidate: CandidateModel) -> tuple[bool, float, float]:
    """Sort ties: what was recorded speaks for a cause before its simplicity, and that before its score."""
    untimed = candidate.active.effect.in_time and data.problem.context.time_s is None
    return untimed, candidate.complexity, candidate.score


def _ties(data: Data, base: Fit, active: Active, known: Ranked | None) -> list[CandidateModel]:
    """List the best candidate in the place of `active` and those that the data cannot tell from it, best first."""
    without = fit_without(data, base, active)
    pairs = candidate_sites(data, base.effects)
    if active.effect.is_fitted:
        pairs = [*pairs, (active.effect, active.site)]
    if known is not None and not without.effects and known.holds_for(data, without):
        ranked = list(known.candidates)
    elif known is not None and not without.effects and known.is_of(data):
        near = [pair for pair in known.within_reach(data, without) if pair in pairs]
        ranked = candidates(data, without, [*near, *(pair for pair in pairs[-1:] if pair not in near)])
    else:
        ranked = candidates(data, without, pairs)
    own = _own(ranked, active, base)
    ranked = sorted([own, *(c for c in ranked if c.active.key != active.key)], key=lambda candidate: candidate.score)
    best = ranked[0]
    excess, remaining = excess_of(data, without), excess_of(data, best.fit)
    return [best, *(other for other in ranked[1:] if tied(data, best, other, excess, remaining))]


def _own(ranked: list[CandidateModel], active: Active, base: Fit) -> CandidateModel:
    """Return the candidate of an effect that is in the model: the better of its new fit and the one it had."""
    mine = [candidate for candidate in ranked if candidate.active.key == active.key]
    held = CandidateModel(active, base, mine[0].complexity if mine else 2.0 * float(np.log(len(base.misfit))))
    return min([held, *mine], key=lambda candidate: candidate.score)
