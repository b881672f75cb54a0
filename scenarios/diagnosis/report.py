"""The page of a diagnosis."""

from __future__ import annotations

from collections.abc import Sequence

from calib.diagnosis.diagnosis import Diagnosis
from scenarios.diagnosis.next_experiment import NextExperiment
from scenarios.diagnosis.resimulate import Resimulation
from scenarios.diagnosis.words import headline
from scenarios.report.page import page


def diagnosis_page(
    name: str, diagnosis: Diagnosis, again: Resimulation, experiment: NextExperiment | None, notes: Sequence[str]
) -> str:
    """Return the report's HTML."""
    return page(f"Diagnosis of {name}", headline(diagnosis), [(diagnosis.verdict, "verdict")], [])
