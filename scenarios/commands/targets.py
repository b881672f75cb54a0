"""`armtwin targets`: what to print for a bench, true to size."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from armtwin.hardware.targets import write_targets
from armtwin.models.errors import InputError


def targets_command(
    out: Annotated[Path, typer.Option("--out", help="PDF to write.")] = Path("targets.pdf"),
    paper: Annotated[str, typer.Option("--paper", help="a4 or letter.")] = "a4",
) -> None:
    """Write a PDF of the calibration board, the stickers and a ruler that checks the printer's scale.

    Print it at 100 %, scaling off, on matt paper.

    Example: armtwin targets --paper a4 --out targets.pdf
    """
    if out.is_dir():
        raise InputError(f"--out: '{out}' is a folder, the name of a PDF is wanted")
    write_targets(out, paper.lower())
    typer.echo(f"Targets written to {out}: print at 100 %, then check a ruler on it with your own")
