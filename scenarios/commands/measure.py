"""`armtwin measure`: from a recording's frames to its markers in pixels."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.progress import Progress
from rich.table import Table

from armtwin.calib.markers import MarkerReading, measure_frames, with_markers
from armtwin.models.errors import InputError
from armtwin.models.recordings.moving_reader import is_moving
from armtwin.models.recordings.reader import read_recording
from armtwin.models.recordings.writer import write_recording
from armtwin.scenarios.commands.outputs import check_out_folder
from armtwin.scenarios.film_angles import angles_of_film, write_moving


class Detector(StrEnum):
    """How the markers are found in a frame."""

    SUBPIXEL = "subpixel"
    PAPER = "paper"


def measure_command(
    recording: Annotated[
        Path, typer.Argument(metavar="RECORDING", help="Folder with recording.json, samples.csv and frames/.")
    ],
    out: Annotated[
        Path, typer.Option("--out", help="Folder for the measured recording; RECORDING itself replaces its pixels.")
    ],
    method: Annotated[
        Detector,
        typer.Option("--method", help="subpixel: edge points and ellipses; paper: its filter chain."),
    ] = Detector.SUBPIXEL,
) -> None:
    """Measure the markers in a recording's frames.

    Writes recording.json and samples.csv with the markers' pixels; an empty cell is a marker that was not seen. Of a
    film of the moving arm it writes the joint angles that the markers show, picture by picture.

    Example: armtwin measure out/paper/recordings/before --method subpixel --out measured
    """
    check_out_folder(out)
    moving = is_moving(recording)
    if moving and out.resolve() == recording.resolve():
        raise InputError(f"--out: {out} is the film itself; name another folder for its joint angles")
    data = read_recording(recording, unmeasured=True, film=moving)
    with Progress(console=Console(stderr=True), transient=True) as progress:
        bar = progress.add_task("Measuring frames", total=len(data))
        readings = measure_frames(data, method.value, progress=lambda done, _: progress.update(bar, completed=done))
    if moving:
        write_moving(out, angles_of_film(with_markers(data, readings)))
    else:
        write_recording(out, with_markers(data, readings))
    _print(Console(), data.arm.marker_names, readings)
    typer.echo(f"Recording written to {out}")


def _print(console: Console, names: tuple[str, ...], readings: tuple[MarkerReading, ...]) -> None:
    table = Table("marker", "seen", "hidden", "ambiguous")
    for name in names:
        states = [reading.status[name] for reading in readings]
        table.add_row(name.upper(), *(str(states.count(state)) for state in ("seen", "hidden", "ambiguous")))
    console.print(table)
    for row, reading in enumerate(readings):
        for message in reading.messages:
            console.print(f"row {row}: {message}", highlight=False, markup=False)
