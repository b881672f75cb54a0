"""How far a faulted world is from every model that could stand for it, after the geometry was fitted with each.

Without noise a model's deviance is its likelihood distance from the world. Around the fit, noise adds to it twice the
product of noise and remainder, and each fitted parameter takes off a square of the noise; the remainders' products with
one another are all that is needed to draw that for all models at once.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from armtwin.calib.diagnosis.candidates import CandidateModel, candidate_sites, fit_candidates
from armtwin.calib.diagnosis.fit import Data, Fit, degrees_of_freedom
from armtwin.calib.diagnosis.search import robust_geometry
from armtwin.calib.diagnosis.structure import typical_misfit
from armtwin.calib.diagnosis.uncertainty import uncertainty
from armtwin.models.catalogue.registry import Effect, effect_named
from armtwin.models.catalogue.site import Site

Array = NDArray[np.float64]

# Rivals that explain less than this part of what the best explains are never taken for it.
_RIVAL_SHARE = 0.3
_MOST_RIVALS = 8

Key = tuple[str, int | None, str | None]


@dataclass(frozen=True, eq=False)
class Contest:
    """One world at one size: the true effect's model first, then its rivals.

    Attributes:
        keys: (effect, joint, marker) of each model.
        distance: (1 + R,) deviance of the geometry alone and of each model without noise.
        gram: (1 + R, 1 + R) products of their remainders, over the noise squared.
        parameters, complexity: of each model, without the geometry.
        typical: (1 + R,) the distance to a value without the worst poses.
        untimed: whether a model needs times that the recording has not.
        free: values less parameters. values: counted. poses: rows.
        tries: sites of the catalogue, over which the level is divided.

    """

    keys: tuple[Key, ...]
    distance: Array
    gram: Array
    parameters: NDArray[np.int64]
    complexity: Array
    typical: Array
    untimed: NDArray[np.bool_]
    free: int
    values: int
    poses: int
    tries: int


def base_fit(data: Data) -> tuple[Data, Fit]:
    """Fit the geometry alone, as the diagnosis begins; the data's terms then know its links."""
    geometric, problem = robust_geometry(data.problem, data.counts, data.noise)
    return Data(problem, data.counts, data.noise), geometric


def own_models(data: Data, base: Fit, name: str, site: Site) -> list[CandidateModel]:
    """Fit the effect that is there at its place; empty where these poses cannot show it at all."""
    effect = effect_named(name)
    if not effect.is_fitted or effect.why_not(data.problem.context, site) is not None:
        return []
    return fit_candidates(data, base, [(effect, site)])


def rivals_of(
    data: Data, base: Fit, own: CandidateModel, among: list[tuple[Effect, Site]] | None
) -> list[CandidateModel]:
    """Fit the other effects and places, of the whole catalogue if `among` is None; keep those that come near."""
    pairs = [
        (effect, site)
        for effect, site in (candidate_sites(data) if among is None else among)
        if (effect.name, site.joint, site.marker) != own.active.key
    ]
    least = _RIVAL_SHARE * float(base.misfit.sum() - own.fit.misfit.sum())
    ranked = fit_candidates(data, base, pairs)
    return [one for one in ranked if float(base.misfit.sum() - one.fit.misfit.sum()) > least][:_MOST_RIVALS]


def contest(data: Data, base: Fit, models: list[CandidateModel]) -> Contest:
    """Hold the models, the true one first, against one another and the geometry alone."""
    fits = [base, *(model.fit for model in models)]
    remainders = np.stack([one.residual[data.counts].ravel() for one in fits]) / data.noise
    context = data.problem.context
    smooth = [
        sum(not p.scanned for p in model.active.effect.parameters(context, model.active.site)) for model in models
    ]
    d = data.problem.observed.shape[-1]
    return Contest(
        keys=tuple(model.active.key for model in models),
        distance=np.array([one.misfit.sum() for one in fits]),
        gram=remainders @ remainders.T,
        parameters=np.maximum(np.array(smooth, dtype=np.int64), 1),
        complexity=np.array([model.complexity for model in models]),
        typical=np.array([typical_misfit(one.misfit, data.counts, d) for one in fits]),
        untimed=np.array([model.active.effect.in_time and context.time_s is None for model in models]),
        free=degrees_of_freedom(data, base),
        values=data.n_values,
        poses=len(base.misfit),
        tries=len(candidate_sites(data)) + 1,
    )


def intervals(data: Data, model: CandidateModel) -> Mapping[str, tuple[float, float]]:
    """Return value and standard deviation of the parameters of the true effect, as this noise would leave them."""
    spread = uncertainty(data, model.fit)
    parameters = model.active.effect.parameters(data.problem.context, model.active.site)
    return {
        p.name: (float(value), float(std))
        for p, value, std in zip(parameters, model.active.values, spread.effects_std[-1], strict=True)
    }
