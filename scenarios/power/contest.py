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
_MOST_RIVALS = 6

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
        as_free: (R, R) whether two models stand at one place and have as many numbers that a gradient finds.
        runs: (1 + R, runs) distances over runs of poses that follow one another.
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
    as_free: NDArray[np.bool_]
    runs: Array
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


def least_of_rivals(base: Fit, own: CandidateModel) -> float:
    """Return the deviance that an effect has to explain to come near the true one."""
    return _RIVAL_SHARE * float(base.misfit.sum() - own.fit.misfit.sum())


def rivals_of(data: Data, base: Fit, own: CandidateModel, pairs: list[tuple[Effect, Site]]) -> list[CandidateModel]:
    """Fit other effects and places; return those that come near."""
    others = [(effect, site) for effect, site in pairs if (effect.name, site.joint, site.marker) != own.active.key]
    least = least_of_rivals(base, own)
    ranked = fit_candidates(data, base, others)
    return [one for one in ranked if float(base.misfit.sum() - one.fit.misfit.sum()) > least][:_MOST_RIVALS]


def contest(data: Data, base: Fit, models: list[CandidateModel]) -> Contest:
    """Hold the models, the true one first, against one another and the geometry alone."""
    fits = [base, *(model.fit for model in models)]
    remainders = np.stack([one.residual[data.counts].ravel() for one in fits]) / data.noise
    context = data.problem.context
    acting = np.array([len(m.active.effect.acting(context, m.active.site, m.active.values)) for m in models])
    sites = [model.active.site for model in models]
    same_site = np.array([[a == b for b in sites] for a in sites])
    by_pose = np.stack([one.misfit.sum(axis=1)[data.counts.any(axis=1)] for one in fits])
    runs = np.array_split(by_pose, max(4, int(np.sqrt(by_pose.shape[1]))), axis=1)
    d = data.problem.observed.shape[-1]
    return Contest(
        keys=tuple(model.active.key for model in models),
        distance=np.array([one.misfit.sum() for one in fits]),
        gram=remainders @ remainders.T,
        parameters=np.maximum(acting, 1),
        complexity=np.array([model.complexity for model in models]),
        typical=np.array([typical_misfit(one.misfit, data.counts, d) for one in fits]),
        untimed=np.array([model.active.effect.in_time and context.time_s is None for model in models]),
        as_free=same_site & (acting[:, None] == acting),
        runs=np.stack([part.sum(axis=1) for part in runs], axis=1),
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
