"""`armtwin snapshot`: photographs of a board by the bench's own camera, with the settings of the bench file."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import typer

from armtwin.calib.camera.board import Board
from armtwin.hardware.bench.bench_file import read_camera_tables
from armtwin.hardware.camera.frame_quality import fault_of
from armtwin.hardware.camera.stillness import to_grey
from armtwin.hardware.camera.webcam import Webcam
from armtwin.hardware.capture.pictures import store
from armtwin.models.errors import InputError
from armtwin.scenarios.commands.interrupts import ended_as_by_ctrl_c
from armtwin.scenarios.commands.outputs import only_results

# Whether its corners are seen does not depend on the size of a square.
_ANY_SQUARE_MM = 20.0
_PATTERN = "view-{:02d}.png"


def snapshot_command(
    bench: Annotated[Path, typer.Option("--bench", help="Bench file (TOML), whose camera is used; no servo moves.")],
    out: Annotated[Path, typer.Option("--out", help="Folder of the photographs; more are added to what is there.")],
    count: Annotated[int, typer.Option("--count", min=1, max=200, help="How many to take.")] = 20,
    board: Annotated[str, typer.Option("--board", help="Inner corners of the chessboard: columns x rows.")] = "9x6",
    size: Annotated[str, typer.Option("--size", help="Width x height of the pictures, px.")] = "1280x720",
    every: Annotated[
        float | None,
        typer.Option("--every", min=0.2, max=60.0, help="Take one every so many seconds, instead of at Enter."),
    ] = None,
) -> None:
    """Photograph the board for armtwin calibrate-camera, with the very focus and exposure that captures will have.

    Says of each photograph whether the board is seen in it; what is black, over-exposed or blurred is not kept. Neither
    the camera's calibration nor the arm needs to be there yet.

    Example: armtwin snapshot --bench bench.toml --out views
    """
    asked = _at_enter(count) if every is None else _after(every)
    take_snapshots(bench, out, count, Board.parse(board, _ANY_SQUARE_MM), _size(size), asked)


def take_snapshots(
    bench: Path, out: Path, count: int, board: Board, size: tuple[int, int], wait: Callable[[int], None]
) -> None:
    """Take `count` photographs; `wait` returns when the one of the given number, from 1, is to be taken."""
    settings, quality = read_camera_tables(bench)
    with only_results(out), ended_as_by_ctrl_c(), Webcam(settings, *size, frozen_s=quality.frozen_s) as webcam:
        for note in webcam.notes:
            typer.echo(f"armtwin: {note}", err=True)
        taken = 0
        while taken < count:
            wait(taken + 1)
            image = webcam.after(webcam.newest().number).image
            grey = to_grey(image)
            fault = fault_of(grey, quality)
            if fault is not None:
                typer.echo(f"not kept: {fault}")
                continue
            taken += 1
            path = _next_in(out)
            store(path, image)
            seen = board.find(path.name, grey, thorough=False) is not None
            typer.echo(f"{path}: " + ("the board is seen" if seen else f"no board of {board} is seen: tilt it less"))
    typer.echo(f"next: armtwin calibrate-camera {out}/*.png --square-mm SIDE --out camera.yaml")


def _next_in(folder: Path) -> Path:
    number = 1
    while (path := folder / _PATTERN.format(number)).exists():
        number += 1
    return path


def _size(text: str) -> tuple[int, int]:
    width, _, height = text.replace("×", "x").partition("x")
    if not (width.isdigit() and height.isdigit()) or not all(16 <= int(n) <= 20_000 for n in (width, height)):
        raise InputError(f"--size: '{text[:40]}' is no width x height in pixels, such as 1280x720")
    return int(width), int(height)


def _at_enter(count: int) -> Callable[[int], None]:
    if not sys.stdin.isatty():
        raise InputError(
            "--every: nobody is at a terminal to press Enter; say every how many seconds one is to be taken"
        )

    def wait(number: int) -> None:
        typer.prompt(
            f"{number} of {count}: hold the board still, press Enter", default="", show_default=False, err=True
        )

    return wait


def _after(seconds: float) -> Callable[[int], None]:
    return lambda _: time.sleep(seconds)
