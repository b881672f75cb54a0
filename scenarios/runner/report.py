"""The last stage: `report.html`."""

from __future__ import annotations

from typing import Any

from armtwin.models import atomic
from armtwin.scenarios.report.data import RunData
from armtwin.scenarios.report.sections import run_report
from armtwin.scenarios.runner.job import Job
from armtwin.scenarios.runner.stage import Tick


def write_report(job: Job, tick: Tick) -> dict[str, Any]:
    """Write the report of the run."""
    atomic.write_text(job.out / "report.html", run_report(RunData(job.out)))
    tick(1, 1)
    return {"written": ["report.html"]}
