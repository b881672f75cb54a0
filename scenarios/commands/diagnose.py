"""`armtwin diagnose`: what the twin of a recording gets wrong, why, and what naming the cause gains."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

from calib.diagnosis.diagnosis import diagnose
from calib.diagnosis.experiment import propose
from calib.markers.recording import measure_recording
from models.atomic import write_json, write_text
from models.effects.registry import register_file
from models.errors import InputError
from models.plan import write_plan
from models.recording import Recording
from models.recording_reader import read_recording
from models.twin import write_twin
from scenarios.diagnosis.checks import check_recording, notes_on
from scenarios.diagnosis.files import written_together
from scenarios.diagnosis.findings import twin_comment, twin_of
from scenarios.diagnosis.report import diagnosis_page
from scenarios.diagnosis.resimulate import compare
from scenarios.diagnosis.sections import Story
from scenarios.diagnosis.summary import print_summary
from scenarios.diagnosis.table import diagnosis_table

# The poses of the proposed experiment, as a plan that a bench can run.
NEXT_PLAN = "next_experiment.csv"


def diagnose_command(
    recording: Annotated[
        Path,
        typer.Argument(
            metavar="RECORDING",
            help="Folder with recording.json and samples.csv; markers that are not measured yet are found in frames/.",
        ),
    ],
    out: Annotated[Path, typer.Option("--out", help="Folder for diagnosis.json, report.html and twin.toml.")],
    effects: Annotated[
        list[Path] | None,
        typer.Option("--effects", metavar="FILE.py", help="An effect of your own (the file is run); repeatable."),
    ] = None,
) -> None:
    """Name what the twin of a recording gets wrong, extend it, and measure the gain on held-out poses.

    Writes diagnosis.json (verdict, causes with intervals, gain), report.html (one file that opens offline) and
    twin.toml (the extended twin, from which the simulated bench is rebuilt); where causes tie also
    next_experiment.csv, the poses that tell them apart.

    Example: armtwin diagnose recordings/circles --out diagnosed
    """
    if out.exists() and not out.is_dir():
        raise InputError(f"{out}: is a file, --out wants a folder")
    for path in effects or ():
        register_file(path)
    columns = (SpinnerColumn(), TextColumn("{task.description}"), TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as progress:
        bar = progress.add_task("reading the recording", total=None)

        def tell(what: str) -> None:
            progress.update(bar, description=what)

        data = measured(recording, tell)
        check_recording(data)
        found = diagnose(data, tell)
        twin = twin_of(found)
        tell("re-simulating the recording with the extended twin")
        again = compare(found, twin, data)
        tell("designing the next experiment")
        experiment = propose(found)
        story = Story(found, again, experiment, notes_on(data))
        tell("writing the report")
        with written_together(out) as aside:
            write_json(aside / "diagnosis.json", diagnosis_table(found, experiment))
            write_text(aside / "report.html", diagnosis_page(recording.resolve().name, story))
            write_twin(aside / "twin.toml", twin, twin_comment(found))
            if experiment is not None:
                write_plan(aside / NEXT_PLAN, experiment.plan)
    print_summary(Console(), story)
    typer.echo(f"Report written to {out / 'report.html'}, diagnosis.json and twin.toml beside it")


def measured(folder: Path, tell: Callable[[str], None]) -> Recording:
    """Read a recording; where it has neither markers nor angles, measure the markers in its frames."""
    if not (folder / "frames").is_dir():
        return read_recording(folder)
    data = read_recording(folder, unmeasured=True)
    if data.markers_px or data.q_meas is not None:
        return data
    return measure_recording(data, progress=lambda done, n: tell(f"measuring markers: frame {done} of {n}"))
