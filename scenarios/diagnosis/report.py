"""The page of a diagnosis."""

from __future__ import annotations

from armtwin.calib.diagnosis.diagnosis import Diagnosis
from armtwin.scenarios.diagnosis.sections import DiagnosisReport, diagnosis_sections
from armtwin.scenarios.diagnosis.words import headline, site_words
from armtwin.scenarios.report.page import page
from armtwin.scenarios.report.section import number


def diagnosis_page(name: str, report: DiagnosisReport) -> str:
    """Return the report's HTML."""
    diagnosis = report.diagnosis
    held = diagnosis.held_out
    answers = [
        _verdict(diagnosis),
        (number(held.before_rms_mm, 3, "mm"), "held-out error, calibrated geometry"),
        (number(held.after_rms_mm, 3, "mm"), "held-out error, extended twin"),
        (number(held.noise_floor_mm, 3, "mm"), "noise floor"),
    ]
    set_up = "".join(f"Set up wrongly: {error.said}.\n" for error in report.screened.errors)
    about = f"{set_up}{headline(diagnosis)}\n{_recording(report)}"
    return page(f"Diagnosis of {name}", about, answers, diagnosis_sections(report), key=("geometry", "extended"))


def _verdict(diagnosis: Diagnosis) -> tuple[str, str]:
    if diagnosis.verdict == "none":
        return "nothing", "is wrong beyond the noise"
    if diagnosis.verdict == "unknown":
        return (
            "unknown",
            "seen on the held-out poses alone" if diagnosis.only_held_out else "no known effect explains it",
        )
    names = [f"{cause.active.effect.name}, {site_words(cause)}" for cause in diagnosis.causes]
    return " and ".join(names), "the cause" if diagnosis.verdict == "named" else "or another: ambiguous"


def _joints(n: int) -> str:
    return "1 joint" if n == 1 else f"{n} joints"


def _recording(report: DiagnosisReport) -> str:
    context = report.diagnosis.problem.context
    seen = f"markers {', '.join(name.upper() for name in context.markers)}" if context.markers else "joint angles"
    clock = "with times" if context.time_s is not None else "without times"
    pull = "gravity in its plane" if context.has_gravity else "no gravity in its plane"
    return f"{len(context)} poses of '{context.arm.name}', {_joints(context.arm.n_joints)}, {seen}, {clock}, {pull}."
