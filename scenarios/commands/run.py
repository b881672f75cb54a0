"""`armtwin run`: a whole experiment on the simulated bench."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.table import Table

from scenarios.runner.job import Job, alone, open_job
from scenarios.runner.run import run_stages
from scenarios.runner.stages import STAGES
from scenarios.runner.world import build_world
from scenarios.scenario import builtin_scenarios, read_scenario


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
) -> None:
    """Run a scenario: camera, gauges, trajectories, calibrations, and the validation line before and after.

    Writes results.json, truth.json, report.html (one file that opens offline) and the recordings with their frames.

    Example: armtwin run paper --out out/paper
    """
    wanted = read_scenario(scenario)
    build_world(wanted)  # what cannot be built is refused before anything is written
    job = open_job(out, wanted)
    with alone(job):
        run_stages(job, STAGES, workers)
    _print(Console(), job)
    typer.echo(f"Report written to {out / 'report.html'}, results to {out / 'results.json'}")


def _print(console: Console, job: Job) -> None:
    found = job.load("validation")
    table = Table("validation", "mean error, mm", "largest, mm", title=job.scenario.title)
    for label, name in (("before calibration", "before"), ("after calibration", "after")):
        run = found["runs"][name]
        table.add_row(label, f"{run['mean_mm']:.3f}", f"{run['max_mm']:.3f}")
    console.print(table)
    console.print(f"Reduced by {found['reduction_percent']:.1f} %")
