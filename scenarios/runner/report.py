"""The last stage: `report.html`."""

from __future__ import annotations

from typing import Any

from models import atomic
from scenarios.report.data import RunData
from scenarios.report.sections import run_report
from scenarios.runner.job import Job
from scenarios.runner.progress import Tick


def write_report(job: Job, tick: Tick) -> dict[str, Any]:
    """Write the report of the run."""
    atomic.write_text(job.out / "report.html", run_report(RunData(job.out)))
    tick(1, 1)
    return {"written": ["report.html"]}
