"""A diagnosis in sentences, for the terminal and the report."""

from __future__ import annotations

import numpy as np

from armtwin.calib.diagnosis.diagnosis import Diagnosis, NamedCause
from armtwin.calib.diagnosis.experiment import Experiment
from armtwin.models.catalogue.registry import Parameter, Stage, effect_named
from armtwin.models.statistics import Z95
from armtwin.scenarios.diagnosis.findings import Estimate, estimates_of
from armtwin.scenarios.diagnosis.resimulate import Resimulation

_ANY = (0.0, np.inf)
# Bounds of scanned parameters that only say which of two ways something is.
_SWITCHES = ((0.0, 1.0), (-1.0, 1.0))
# A switch that was found on or off is not known to fifteen digits; it has no interval.
_EXACT = 1e-9


def headline(diagnosis: Diagnosis) -> str:
    """Return the verdict in one sentence."""
    named = " and ".join(cause.active.label for cause in diagnosis.causes)
    if diagnosis.verdict == "none":
        return "Nothing is wrong beyond the noise: the calibrated geometry explains the recording."
    if diagnosis.verdict == "named":
        doubt = ", unproven: the held-out poses do not bear it out" if unproven(diagnosis) else ""
        return f"The cause{'s are' if len(diagnosis.causes) > 1 else ' is'} {named}{doubt}."
    if diagnosis.verdict == "ambiguous":
        tied = [cause for cause in diagnosis.causes if cause.equivalents]
        ties = "; ".join(f"{c.active.label} from {' or '.join(o.label for o in c.equivalents)}" for c in tied)
        sure = [cause.active.label for cause in diagnosis.causes if not cause.equivalents]
        return f"These poses cannot tell {ties}" + (f"; besides, {' and '.join(sure)}." if sure else ".")
    nearest = " and ".join(cause.active.label for cause in diagnosis.suspects)
    text = (
        "The poses held out show what the others do not"
        if diagnosis.only_held_out
        else "What remains is more than the noise, and no known effect explains it"
    )
    return text + (f"; {nearest} comes nearest." if nearest else ".")


def unproven(diagnosis: Diagnosis) -> bool:
    """Whether fitted causes are named that gain nothing certain on held-out poses."""
    return bool(diagnosis.explanation.causes) and not diagnosis.held_out.bears_out


def gain(diagnosis: Diagnosis) -> str:
    """Return what naming the cause gained on held-out poses, in one sentence."""
    held = diagnosis.held_out
    text = (
        f"On {held.n_poses} poses that nothing was fitted to, the error is {held.nominal_rms_mm:.3g} mm by the "
        f"drawing, {held.before_rms_mm:.3g} mm with the calibrated geometry and {held.after_rms_mm:.3g} mm with the "
        f"extended twin; the noise floor is {held.noise_floor_mm:.3g} mm"
    )
    if held.before_rms_mm == held.after_rms_mm:
        return f"{text}."
    low, high = held.gain_ci95_percent
    return f"{text}. That is {held.gain_percent:.1f} % less (95 % interval {low:.1f} to {high:.1f} %)."


def missed(again: Resimulation) -> str:
    """Return how far the re-simulated twin is from the recording, in one sentence."""
    return (
        f"Re-simulated in MuJoCo, the extended twin misses the recording by {again.rms_mm:.3g} mm RMS "
        f"({again.held_out_rms_mm:.3g} mm on the held-out poses)."
    )


def what_next(diagnosis: Diagnosis, experiment: Experiment | None) -> str:
    """Return what to do now."""
    if experiment is not None:
        by_hand = "".join(f" {step[0].upper()}{step[1:]}." for step in experiment.instructions)
        return f"Run '{experiment.trajectory}' next ({len(experiment.plan)} poses): {experiment.why}.{by_hand}"
    if diagnosis.verdict == "none":
        return "Use the calibrated arm as it is."
    if diagnosis.only_held_out:
        return (
            "Hold out other trajectories ('held_out' in recording.json) and diagnose again: what happened in these can "
            "be named once they are fitted."
        )
    if diagnosis.verdict == "unknown":
        return (
            "Look at what the remainder follows; add an effect of your own with --effects, or record more varied poses."
        )
    if all(cause.active.effect.stage == Stage.OBSERVATION for cause in diagnosis.causes):
        return f"The arm is right; {diagnosis.causes[0].active.effect.experiment}."
    if unproven(diagnosis):
        cause = diagnosis.causes[0].active
        return (
            "The gain's interval includes nothing, so the name is not proven: hold out poses in which it would show, "
            f"as {cause.effect.experiment}, and diagnose again before twin.toml is used."
        )
    return "Use twin.toml: it is the arm with this cause in it."


def why_tied(cause: NamedCause) -> list[str]:
    """Say for each equivalent why these poses cannot break the tie, and what would."""
    lines = []
    for other in cause.equivalents:
        both = effect_named(cause.active.effect.name)
        known = other.effect.name in both.confused_with or both.name in other.effect.confused_with
        same = "the two are known to look alike" if known else "on these poses the two predict the same"
        lines.append(
            f"{cause.active.label} or {other.label}: {same}, and neither leaves less than the other beyond the noise. "
            f"To tell them apart: {both.experiment}; or {other.effect.experiment}."
        )
    return lines


def parameter_rows(cause: NamedCause, diagnosis: Diagnosis) -> list[tuple[str, str, str]]:
    """Return name, value and 95 % interval of each parameter as people read them; angles in degrees too.

    Switches and the side from which a bench set out are for `diagnosis.json` alone.
    """
    parameters = {p.name: p for p in cause.active.effect.parameters(diagnosis.problem.context, cause.active.site)}
    return [
        (name, _value(name, estimate), _interval(estimate, parameters[name].bounds if name in parameters else _ANY))
        for name, estimate in estimates_of(cause, diagnosis).items()
        if not (name in parameters and _is_switch(parameters[name]))
    ]


def _is_switch(parameter: Parameter) -> bool:
    return parameter.scanned and parameter.bounds in _SWITCHES


def site_words(cause: NamedCause) -> str:
    """Return where a cause sits: a joint, a marker, or what it is an effect of."""
    site, where = cause.active.site, cause.active.effect.where
    if site.joint is not None:
        return f"{'link' if where == 'link' else 'joint'} {site.joint}"
    if site.marker is not None:
        return f"marker {site.marker.upper()}"
    return "camera" if where == "camera" else "whole arm"


def _value(name: str, estimate: Estimate) -> str:
    degrees = f" ({np.degrees(estimate.value):.3g}°)" if name.endswith("_rad") else ""
    return f"{estimate.value:.4g}{degrees}"


def _interval(estimate: Estimate, bounds: tuple[float, float]) -> str:
    """Write the interval within what is physically possible; a dash where none is known."""
    reach = Z95 * estimate.std
    if not np.isfinite(reach) or reach < _EXACT * max(abs(estimate.value), 1.0):
        return "–"
    low, high = np.clip([estimate.value - reach, estimate.value + reach], *bounds)
    return f"{low:.4g} to {high:.4g}"
