"""The models between which a diagnosis could not decide."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from armtwin.calib.diagnosis.diagnosis import Diagnosis
from armtwin.calib.diagnosis.fit import Data, Fit, fit
from armtwin.models.catalogue.predict import Active
from armtwin.models.catalogue.registry import Stage, catalogue

# A named cause that beats what it is easily taken for by less deviance than this is worth a further look: with a
# Gaussian's odds of exp(25 / 2) it holds, but no term has exactly the world's form.
_NARROW = 25.0
_MOST = 3


@dataclass(frozen=True, eq=False)
class Rivals:
    """Models (at least two) that stand for the same part of the misfit, best first, and the effects they say it is."""

    models: tuple[Fit, ...]
    effects: tuple[Active | None, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the effects in question; `none` for the model without one."""
        return tuple("none" if effect is None else effect.effect.name for effect in self.effects)


def rivals_of(diagnosis: Diagnosis) -> list[Rivals]:
    """Return what the verdict leaves open: ties, narrow decisions, or suspects of an unknown cause."""
    found = diagnosis.explanation
    data, final = found.data, found.final
    groups = []
    for cause in diagnosis.causes:
        if cause.active.effect.term is None:
            continue  # found sample by sample: no poses would show it better
        others = cause.equivalents or _confusable(data, final, cause.active)
        group = _group(data, final, cause.active, others)
        if not cause.equivalents:
            group = _narrow(group)
        if len(group.models) > 1:
            groups.append(group)
    if diagnosis.verdict == "unknown":
        suspects = [cause.active for cause in diagnosis.suspects if cause.active.effect.term is not None]
        suspects += [candidate.active for candidate in found.considered if candidate.active.effect.term is not None]
        models = [fit(data, found.geometric.g, (suspect,)) for suspect in suspects[:_MOST]]
        if models:
            groups.append(Rivals((*models, found.geometric), (*suspects[:_MOST], None)))
    return groups


def _group(data: Data, final: Fit, active: Active, others: Sequence[Active]) -> Rivals:
    """Fit every rival in the place of `active`."""
    rest = tuple(other for other in final.effects if other.key != active.key)
    models = [final, *(fit(data, final.g, (*rest, other)) for other in others[: _MOST - 1])]
    return Rivals(tuple(models), (active, *(model.effects[-1] for model in models[1:])))


def _narrow(group: Rivals) -> Rivals:
    """Keep the rivals that come near the best."""
    near = [k for k, model in enumerate(group.models) if model.deviance < group.models[0].deviance + _NARROW]
    return Rivals(tuple(group.models[k] for k in near), tuple(group.effects[k] for k in near))


def _confusable(data: Data, final: Fit, active: Active) -> list[Active]:
    """Effects that the catalogue says `active` is easily taken for, at the same site, from their best start."""
    context = data.problem.context
    held = {other.key for other in final.effects}
    found = []
    for name in active.effect.confused_with:
        effect = catalogue().get(name)
        if effect is None or effect.term is None or (not data.problem.is_pixels and effect.stage > Stage.JOINT):
            continue
        sites = effect.sites(context)
        site = active.site if active.site in sites else sites[0]
        starts = list(effect.starts(context, site, None)) if effect.why_not(context, site) is None else []
        if starts and (name, site.joint, site.marker) not in held:
            found.append(_best_start(data, final, active, [Active(effect, site, values) for values in starts]))
    return found


def _best_start(data: Data, final: Fit, active: Active, starts: Sequence[Active]) -> Active:
    """Return the start that explains most after a few iterations."""
    rest = tuple(other for other in final.effects if other.key != active.key)
    fits = [fit(data, final.g, (*rest, start), iterations=2) for start in starts]
    return min(fits, key=lambda one: one.deviance).effects[-1]
