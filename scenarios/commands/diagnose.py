"""`armtwin diagnose`: what the twin of a recording gets wrong, why, and what naming the cause gains."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

from calib.markers.recording import measure_recording
from models.effects.registry import register_file
from models.errors import InputError
from models.recording import Recording
from models.recording_reader import read_recording
from scenarios.diagnosis.summary import print_summary
from scenarios.diagnosis.whole import story_of, write_story


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

        story = story_of(measured(recording, tell), tell)
        tell("writing the report")
        write_story(out, recording.resolve().name, story)
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
