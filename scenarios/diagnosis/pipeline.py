"""A diagnosis from the recording to the files: what the commands and the runs of scenarios share."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from armtwin.calib.diagnosis.diagnosis import diagnose
from armtwin.calib.diagnosis.experiment import propose
from armtwin.calib.setup.screen import screen
from armtwin.models.atomic import write_json, write_text
from armtwin.models.plan import write_plan
from armtwin.models.recordings.part import shortened
from armtwin.models.recordings.recording import Recording
from armtwin.models.twin import write_twin
from armtwin.scenarios.diagnosis.checks import check_recording, notes_on, part_note
from armtwin.scenarios.diagnosis.files import written_together
from armtwin.scenarios.diagnosis.findings import twin_comment, twin_of
from armtwin.scenarios.diagnosis.report import diagnosis_page
from armtwin.scenarios.diagnosis.resimulate import compare
from armtwin.scenarios.diagnosis.sections import DiagnosisReport
from armtwin.scenarios.diagnosis.table import diagnosis_table

# The poses of the proposed experiment, as a plan that a bench can run.
NEXT_PLAN = "next_experiment.csv"


def report_on(recording: Recording, tell: Callable[[str], None] = lambda _: None) -> DiagnosisReport:
    """Screen a recording for gross errors of its set-up, diagnose it without them, and design the next experiment.

    `tell` hears what is being done. Raises `RecordingError` where nothing can be decided.
    """
    whole = len(recording)
    recording = shortened(recording)
    looked_at = part_note(len(recording), whole)
    screened = screen(recording)
    recording = screened.recording
    check_recording(recording)
    found = diagnose(recording, tell)
    tell("re-simulating the recording with the extended twin")
    again = compare(found, twin_of(found), recording)
    tell("designing the next experiment")
    return DiagnosisReport(found, again, propose(found), [*looked_at, *notes_on(recording)], screened)


def write_report(folder: Path, name: str, report: DiagnosisReport) -> None:
    """Write diagnosis.json, report.html, twin.toml and, where causes tie, next_experiment.csv; all or none of them."""
    with written_together(folder) as aside:
        write_json(aside / "diagnosis.json", diagnosis_table(report.diagnosis, report.experiment, report.screened))
        write_text(aside / "report.html", diagnosis_page(name, report))
        write_twin(aside / "twin.toml", twin_of(report.diagnosis), twin_comment(report.diagnosis))
        if report.experiment is not None:
            write_plan(aside / NEXT_PLAN, report.experiment.plan)
    if report.experiment is None:  # what an earlier diagnosis proposed is no advice any more
        (folder / NEXT_PLAN).unlink(missing_ok=True)
