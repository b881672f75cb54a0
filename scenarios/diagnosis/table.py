"""The diagnosis as data: the content of `diagnosis.json` (`armtwin.diagnosis/1`)."""

from __future__ import annotations

from typing import Any

from armtwin.calib.diagnosis.diagnosis import Diagnosis, NamedCause
from armtwin.calib.diagnosis.experiment import Experiment
from armtwin.calib.setup.screen import Screened
from armtwin.scenarios.diagnosis.causes import cause_table
from armtwin.scenarios.diagnosis.findings import estimates_of

SCHEMA = "armtwin.diagnosis/1"


def diagnosis_table(
    diagnosis: Diagnosis, experiment: Experiment | None, screened: Screened | None = None
) -> dict[str, Any]:
    """Return the content of `diagnosis.json`; `set_up` stands in it where gross errors of the set-up were found."""
    geometry, held_out = diagnosis.geometry, diagnosis.held_out
    errors = () if screened is None else screened.errors
    set_up = [{"error": e.error, "joints": list(e.joints), "said": e.said, "remedy": e.remedy} for e in errors]
    estimates = zip(geometry.names, geometry.values, geometry.std, strict=True)
    return {
        "schema": SCHEMA,
        "verdict": diagnosis.verdict,
        **({"set_up": set_up} if set_up else {}),
        "causes": [_cause(cause, diagnosis) for cause in diagnosis.causes],
        "geometry": {
            "identifiable": geometry.identifiable,
            "parameters": {name: {"value": value, "std": std} for name, value, std in estimates},
            "gauge": list(geometry.gauge),
        },
        "held_out": {
            "trajectories": list(held_out.trajectories),
            "nominal_rms_mm": held_out.nominal_rms_mm,
            "before_rms_mm": held_out.before_rms_mm,
            "after_rms_mm": held_out.after_rms_mm,
            "noise_floor_mm": held_out.noise_floor_mm,
            "gain_percent": held_out.gain_percent,
            "gain_ci95_percent": list(held_out.gain_ci95_percent),
        },
        "unexplained": {
            "rms_mm": diagnosis.unexplained_rms_mm,
            "structured": bool(diagnosis.trends_after),
            "against": [trend.against for trend in diagnosis.trends_after],
        },
        "next_experiment": None
        if experiment is None
        else {
            "trajectory": experiment.trajectory,
            "tells_apart": list(experiment.tells_apart),
            "why": experiment.why,
        },
    }


def _cause(cause: NamedCause, diagnosis: Diagnosis) -> dict[str, Any]:
    estimates = estimates_of(cause, diagnosis).items()
    return cause_table(cause, {name: {"value": one.value, "std": one.std} for name, one in estimates})
