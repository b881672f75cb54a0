"""The option `--effects`: effects of a person's own, by their files."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from armtwin.models.catalogue.registry import register_file

OwnEffects = Annotated[
    list[Path] | None,
    typer.Option("--effects", metavar="FILE.py", help="An effect of your own (the file is run); repeatable."),
]


def register_own(effects: list[Path] | None) -> None:
    """Register the effects of these files; raises `InputError` for what is none."""
    for path in effects or ():
        register_file(path)
