"""`armtwin run`: a whole experiment on the simulated bench."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.table import Table
from rich.text import Text

from armtwin.scenarios.commands.own_effects import OwnEffects, register_own
from armtwin.scenarios.report.line_figures import LABELS
from armtwin.scenarios.runner.experiment import run_experiment
from armtwin.scenarios.runner.job import Job
from armtwin.scenarios.scenario import builtin_scenarios


def run_command(
    scenario: Annotated[
        str,
        typer.Argument(
            metavar="SCENARIO",
            help=f"A scenario that comes with armtwin ({', '.join(builtin_scenarios())}), or a TOML file.",
        ),
    ],
    out: Annotated[Path, typer.Option("--out", help="Folder for the results; a killed run there is gone on with.")],
    workers: Annotated[int, typer.Option("--workers", min=1, max=2, help="Processes that work at a time.")] = 2,
    effects: OwnEffects = None,
) -> None:
    """Run a scenario: camera, gauges, trajectories, calibrations, diagnosis, and the validation line three times.

    Writes results.json, truth.json, report.html (one file that opens offline), the recordings with their frames, and
    diagnosis/ with what was found beyond the geometry and the twin that was extended by it.

    Example: armtwin run paper --out out/paper
    """
    register_own(effects)
    job = run_experiment(scenario, out, workers)
    _print(Console(), job)
    typer.echo(f"Report written to {out / 'report.html'}, results to {out / 'results.json'}")


def _print(console: Console, job: Job) -> None:
    gain = job.load("gain")
    table = Table("validation", "mean error, mm", "largest, mm", "reduced by", title=job.scenario.title)
    for row in gain["rows"]:
        less = "" if row["run"] == "before" else f"{row['reduction_percent']:.1f} %"
        table.add_row(LABELS[row["run"]], f"{row['mean_mm']:.3f}", f"{row['max_mm']:.3f}", less)
    console.print(table)
    if gain["corrected_camera"]:
        means = " → ".join(f"{row['mean_by_twin_camera_mm']:.3f}" for row in gain["rows"])
        console.print(Text(f"The camera itself was corrected; through the extended twin's camera: {means} mm"))
    console.print(Text(job.load("diagnose")["words"]["headline"]))
