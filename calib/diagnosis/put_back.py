"""Points that were left out as gross errors beside a poorer model are put back, and causes are looked for with them.

The poses at which a threshold shows are few and far off: once they are left out, another threshold explains the rest.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from armtwin.calib.diagnosis.candidates import candidate_sites, fit_candidates
from armtwin.calib.diagnosis.fit import Data, Fit, fit
from armtwin.calib.diagnosis.repairs import Repaired, repair

# Rounds in which what is left out by a better model is found.
_ROUNDS = 2


@dataclass(frozen=True, eq=False)
class Mended:
    """A model, the data that it was fitted to, and what was repaired of these."""

    repaired: Repaired
    data: Data
    model: Fit

    def price(self, raw: Data) -> float:
        """Deviance, and twice the logarithm of the values for each point that is left out."""
        left_out = int(raw.counts.sum()) - int(self.data.counts.sum())
        return self.model.deviance + 2.0 * float(np.log(max(raw.n_values, 2))) * left_out


def put_back(raw: Data, now: Mended) -> Mended:
    """Return the model in which a cause was looked for with every point, where that leaves fewer of them out."""
    best = now
    for active in now.model.effects:
        if best.data.counts.sum() == raw.counts.sum():
            break
        if not active.effect.is_fitted:
            continue
        everything = replace(raw, problem=raw.problem.with_links(now.model.g))
        others = tuple(other for other in now.model.effects if other.key != active.key)
        without = fit(everything, now.model.g, others)
        alike = [pair for pair in candidate_sites(everything, others) if pair[1].joint and pair[1] == active.site]
        for found in fit_candidates(everything, without, alike or [(active.effect, active.site)]):
            trial = _repaired(everything, found.fit)
            if trial.price(raw) < best.price(raw):
                best = trial
    return best


def _repaired(everything: Data, model: Fit) -> Mended:
    repaired = Repaired(everything, ())
    for _ in range(_ROUNDS):
        repaired = repair(everything, model)
        model = fit(repaired.data, model.g, model.effects)
    return Mended(repaired, repaired.data, model)
