"""What was found, in numbers: the parameters of a cause with their spread, and as the simulated bench takes them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from armtwin.calib.diagnosis.diagnosis import Diagnosis, NamedCause
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
    if active.effect.find is None:
        told, context = active.effect.told, diagnosis.problem.context
        wanted = range(len(cause.names)) if told is None else told(context, active.values)
        return {cause.names[k]: Estimate(float(active.values[k]), float(cause.std[k])) for k in wanted}
    if active.effect.name == "outliers":
        return _outliers(active, diagnosis)
    rows = active.effect.physical(diagnosis.problem.context, active.values) if active.effect.physical else {}
    return {"count": Estimate(float(len(rows.get("samples", ()))), 0.0)}


def twin_of(diagnosis: Diagnosis) -> Twin:
    """Return the extended twin: the calibrated geometry with every effect of the final model.

    Misread angles are left out: the simulated bench has a detector that errs, but no protractor.
    """
    context = diagnosis.problem.context
    found = [active for active in diagnosis.explanation.found if context.camera or active.effect.name != "outliers"]
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
    if active.effect.name == "outliers":
        return {name: estimate.value for name, estimate in _outliers(active, diagnosis).items()}
    return active.effect.built(context, active.site, active.values)


def _outliers(active: Active, diagnosis: Diagnosis) -> dict[str, Estimate]:
    """Share of the sightings that are gross errors, and their mean distance in pixels."""
    rows, columns = active.values.reshape(-1, 2).astype(int).T
    data, final = diagnosis.explanation.data, diagnosis.explanation.final
    missed = data.problem.observed[rows, columns] - data.problem.predict(final.g, final.effects)[rows, columns]
    far = np.linalg.norm(missed, axis=-1)
    seen = int(data.counts.sum()) + len(rows)
    rate = len(rows) / seen
    size = "size_px" if diagnosis.problem.is_pixels else "size_rad"
    return {
        "rate": Estimate(rate, float(np.sqrt(rate * (1.0 - rate) / seen))),
        size: Estimate(float(far.mean()), float(far.std(ddof=1) / np.sqrt(len(far))) if len(far) > 1 else float("nan")),
    }


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
