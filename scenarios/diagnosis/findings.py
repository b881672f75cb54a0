"""What was found, in numbers: the parameters of a cause with their spread, and as the simulated bench takes them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from armtwin.calib.diagnosis.diagnosis import Diagnosis, NamedCause
from armtwin.calib.diagnosis.repairs import repaired
from armtwin.models.catalogue.effect import Stage
from armtwin.models.catalogue.evidence import Sightings
from armtwin.models.catalogue.predict import Active
from armtwin.models.twin import Twin, TwinEffect


@dataclass(frozen=True)
class Estimate:
    """A value with its standard deviation."""

    value: float
    std: float


def estimates_of(cause: NamedCause, diagnosis: Diagnosis) -> dict[str, Estimate]:
    """Return the parameters of a cause by name; of single samples how many, or how often and how far."""
    active = cause.active
    if active.effect.found is None:
        told, context = active.effect.told, diagnosis.problem.context
        wanted = range(len(cause.names)) if told is None else told(context, active.values)
        return {cause.names[k]: Estimate(float(active.values[k]), float(cause.std[k])) for k in wanted}
    if active.effect.found.measure is not None:
        return _measured(active, diagnosis)
    if active.effect.physical is None:
        return {"count": Estimate(float(len(active.values)), 0.0)}
    built = active.effect.physical(diagnosis.problem.context, active.values)
    samples = {sample for value in built.values() if isinstance(value, list) for sample in value}
    return {"count": Estimate(float(len(samples)), 0.0)}


def twin_of(diagnosis: Diagnosis) -> Twin:
    """Return the extended twin: the calibrated geometry with every effect of the final model.

    Misread angles are left out: the simulated bench has a detector that errs, but no protractor.
    """
    context = diagnosis.problem.context
    found = [a for a in diagnosis.explanation.found if context.camera or a.effect.stage < Stage.OBSERVATION]
    actives = [*diagnosis.explanation.final.effects, *found]
    return Twin(
        arm=context.arm,
        deviation=diagnosis.geometry.deviation,
        base_in_board_mm=diagnosis.geometry.base_in_board_mm,
        camera=context.camera,
        effects=tuple(
            TwinEffect(active.effect.name, active.site.joint, active.site.marker, injected(active, diagnosis))
            for active in actives
        ),
    )


def injected(active: Active, diagnosis: Diagnosis) -> dict[str, Any]:
    """Return the parameters of a found effect as its injector takes them."""
    context = diagnosis.problem.context
    if active.effect.found is not None and active.effect.found.measure is not None:
        return {name: estimate.value for name, estimate in _measured(active, diagnosis).items()}
    return active.effect.built(context, active.site, active.values)


def _measured(active: Active, diagnosis: Diagnosis) -> dict[str, Estimate]:
    """Return what is told of single samples by how far they are from where the final model has them."""
    assert active.effect.found is not None
    assert active.effect.found.measure is not None
    untouched, data, final = (getattr(diagnosis.explanation, name) for name in ("untouched", "data", "final"))
    alone = repaired(untouched, active)
    before = Sightings(untouched.problem.observed, untouched.counts)
    touched = before.differ(Sightings(alone.problem.observed, alone.counts))
    missed = (untouched.problem.observed - data.problem.predict(final.g, final.effects))[touched]
    measured = active.effect.found.measure(missed, int(data.counts.sum()))
    return {name: Estimate(value, std) for name, (value, std) in measured.items()}


def twin_comment(diagnosis: Diagnosis) -> str:
    """Return what a reader of the twin file has to know: how sure its effects are."""
    lines = ["Extended twin: the calibrated arm with the effects that were found, as the simulated bench makes them."]
    if diagnosis.verdict == "unknown":
        lines.append("The cause is unknown: what stands here describes the recording best, and is not proven.")
    for cause in diagnosis.causes:
        if cause.equivalents:
            others = ", ".join(other.label for other in cause.equivalents)
            lines.append(f"{cause.active.label}: these poses cannot tell it from {others}.")
    return "\n".join([*lines, *diagnosis.geometry.gauge])
