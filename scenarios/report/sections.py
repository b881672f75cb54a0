"""The sections of a run's report, in the order in which its story is told."""

from __future__ import annotations

from collections.abc import Callable

from armtwin.scenarios.report.bench_section import bench_section
from armtwin.scenarios.report.calibration_section import calibration_section
from armtwin.scenarios.report.camera_section import camera_section
from armtwin.scenarios.report.data import RunData
from armtwin.scenarios.report.diagnosis_section import causes_section, remainder_section
from armtwin.scenarios.report.findings_section import paper_section
from armtwin.scenarios.report.gain_section import gain_section
from armtwin.scenarios.report.gauge_section import gauge_section, worst_of
from armtwin.scenarios.report.page import page
from armtwin.scenarios.report.section import Section, number
from armtwin.scenarios.report.trajectory_section import trajectory_section
from armtwin.scenarios.report.validation_section import validation_section

SECTIONS: tuple[Callable[[RunData], Section], ...] = (
    bench_section,
    camera_section,
    gauge_section,
    trajectory_section,
    calibration_section,
    validation_section,
    remainder_section,
    causes_section,
    gain_section,
    paper_section,
)


def run_report(run: RunData) -> str:
    """Return the whole report of a finished run as HTML."""
    scenario = run.results["scenario"]
    return page(scenario["title"], scenario["about"], _answers(run), [make(run) for make in SECTIONS])


def _answers(run: RunData) -> list[tuple[str, str]]:
    """Say in a few numbers what the run found."""
    validation = run.results["validation"]
    gain = {row["run"]: row for row in run.results["gain"]["rows"]}
    errors = " → ".join(number(row["mean_mm"], 3) for row in gain.values())
    by_twin, by_geometry = (number(gain[name]["reduction_percent"], 1) for name in ("extended", "after"))
    spread = [r for r in run.results["tables"]["3"] if r["detector"] == "subpixel"]
    camera = worst_of(spread)
    found = run.results["tables"]["4"]["least-squares"][-1]["identifiable"]
    return [
        (
            f"{errors} mm",
            f"mean error on the validation line: before calibration, after it, with the extended twin (the paper: "
            f"{number(validation['paper']['mean_before_mm'], 2)} → {number(validation['paper']['mean_after_mm'], 2)})",
        ),
        (f"{by_twin} %", f"less error; by geometry alone {by_geometry} % (the paper: 54.6 %)"),
        (f"{number(camera, 3)} mm", "largest bias or spread of the camera on gauges (the paper: 0.23)"),
        (f"{found} of 7", "geometric parameters that the pictures can tell"),
    ]
