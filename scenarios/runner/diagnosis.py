"""What the calibrated arm still gets wrong, and the commands by which its extended twin runs the validation."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from armtwin.calib.diagnosis.diagnosis import Diagnosis, NamedCause
from armtwin.models.camera import Camera
from armtwin.models.catalogue.correct import Correction, corrected_commands
from armtwin.models.catalogue.predict import Active, camera_path
from armtwin.models.recordings.writer import camera_table
from armtwin.models.statistics import Z95
from armtwin.scenarios.diagnosis.causes import cause_table, place_of
from armtwin.scenarios.diagnosis.findings import estimates_of
from armtwin.scenarios.diagnosis.pipeline import report_on, write_report
from armtwin.scenarios.diagnosis.sections import DiagnosisReport, diagnosis_sections
from armtwin.scenarios.diagnosis.table import diagnosis_table
from armtwin.scenarios.diagnosis.words import gain, headline, missed, why_tied
from armtwin.scenarios.report.section import Section
from armtwin.scenarios.runner.job import Job
from armtwin.scenarios.runner.measure import recorded
from armtwin.scenarios.runner.stage import Tick

Array = NDArray[np.float64]

# What `armtwin diagnose` writes, beside the run's own files.
FOLDER = "diagnosis"


def diagnose_arm(job: Job, tick: Tick) -> dict[str, Any]:
    """Diagnose the recording made before calibration, its validation trajectory held out, and extend the twin.

    Nothing but the recording is known to it. Writes diagnosis.json, report.html and twin.toml into `diagnosis/`.
    """
    report = report_on(recorded(job, "before"))
    tick(1, 2)
    write_report(job.out / FOLDER, job.scenario.title, report)
    path = job.scenario.trajectories[job.scenario.validate_on].poses()
    correction = corrected_line(report.diagnosis, path)
    tick(2, 2)
    return {
        "found": diagnosis_table(report.diagnosis, report.experiment),
        "causes": [_cause(cause, report.diagnosis) for cause in (*report.diagnosis.causes, *report.diagnosis.suspects)],
        "words": _words(report),
        "corrected_with": [
            {"label": active.label, "where": active.effect.where}
            for active in report.diagnosis.explanation.final.effects
        ],
        "camera": camera_table(camera_now(report.diagnosis)),
        "q_cmd_rad": correction.q_cmd,
        "missed_rad": correction.missed_rad,
        "chapters": [_chapter(section) for section in diagnosis_sections(report)],
    }


def corrected_line(diagnosis: Diagnosis, poses: Array) -> Correction:
    """Return the commands for (N, 3) poses x mm, y mm, theta rad, by the geometry and the causes that were found.

    They hold on a bench that has just run the commands of the diagnosed recording: play and friction remember them.
    Models that these poses cannot tell apart predict alike, so of tied causes the one that was fitted serves. Raises
    `UnreachablePoseError`.
    """
    explanation = diagnosis.explanation
    history = explanation.data.problem.context
    return corrected_commands(history, diagnosis.geometry.deviation, explanation.final.effects, poses)


def camera_now(diagnosis: Diagnosis) -> Camera:
    """Return the camera as the extended twin has it at the end of the recording: tilted, bumped, refocused."""
    explanation = diagnosis.explanation
    context = explanation.data.problem.context
    assert context.camera is not None
    path = camera_path(context, explanation.final.effects)
    camera = context.camera.moved(Rotation.from_rotvec(path.rotation_rad[-1]).as_matrix(), path.translation_mm[-1])
    K = camera.K.copy()
    K[:2, :2] *= path.focal_scale[-1]
    return replace(camera, K=K, lens=camera.lens.changed(path.distortion))


def _cause(cause: NamedCause, diagnosis: Diagnosis) -> dict[str, Any]:
    """Return a cause with the interval of each parameter, within what is physically possible."""
    site, effect = cause.active.site, cause.active.effect
    known = {p.name: p for p in effect.parameters(diagnosis.problem.context, site)}
    parameters = []
    for name, estimate in estimates_of(cause, diagnosis).items():
        bounds = known[name].bounds if name in known else (0.0, np.inf)
        reach = Z95 * estimate.std
        interval = np.clip([estimate.value - reach, estimate.value + reach], *bounds)
        switch = name in known and known[name].scanned
        parameters.append(
            {
                "name": name,
                "value": estimate.value,
                "std": estimate.std,
                "interval95": interval,
                # What is not stated of an injected effect is off; of a switch or a sample nothing is known.
                "unstated": None if switch or name not in known else known[name].off,
            }
        )
    return cause_table(cause, parameters, _labelled)


def _labelled(active: Active) -> dict[str, Any]:
    return place_of(active) | {"label": active.label}


def _words(report: DiagnosisReport) -> dict[str, Any]:
    return {
        "headline": headline(report.diagnosis),
        "gain": gain(report.diagnosis),
        "resimulated": missed(report.resimulation),
        "ties": [line for cause in report.diagnosis.causes for line in why_tied(cause)],
    }


def _chapter(section: Section) -> dict[str, Any]:
    """Return a chapter of the diagnosis' report as text, for the run's report to take up."""
    return {
        "slug": section.slug,
        "title": section.title,
        "lead": section.lead,
        "blocks": [str(block) for block in section.blocks],
    }
