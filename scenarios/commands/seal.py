"""`armtwin seal`: recordings with hidden effects, and the truth in a file of its own."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.progress import Progress

from armtwin.models.catalogue.registry import register_file
from armtwin.models.errors import InputError
from armtwin.scenarios.commands.outputs import check_out_folder
from armtwin.scenarios.scoring.orders import SealOptions
from armtwin.scenarios.scoring.sealing import seal


def seal_command(
    out: Annotated[
        Path, typer.Option("--out", help="Folder for worlds/ and truth.json; a set broken off is gone on with.")
    ],
    n: Annotated[int, typer.Option("--n", min=1, max=9999, help="Number of worlds.")] = 50,
    seed: Annotated[int, typer.Option("--seed", min=0, max=2**63 - 1, help="The same seed gives the same worlds.")] = 0,
    frames: Annotated[bool, typer.Option("--frames", help="Render every pose and measure the pictures.")] = False,
    effects: Annotated[
        str | None,
        typer.Option(
            "--effects",
            help="Only these effects, separated by commas: names, 'none', or your own FILE.py (which is run).",
        ),
    ] = None,
    pairs: Annotated[bool, typer.Option("--pairs", help="Hide two effects in a fifth of the worlds.")] = False,
    uncatalogued: Annotated[
        Path | None,
        typer.Option("--uncatalogued", help="Python file of faults that no effect describes (it is run), for a sixth."),
    ] = None,
    moving: Annotated[
        bool, typer.Option("--moving", help="Logs of a moving arm, with effects in time, for a sixth unknown ones.")
    ] = False,
    jobs: Annotated[int, typer.Option("--jobs", min=1, max=64, help="Processes at a time.")] = 2,
) -> None:
    """Make recordings of the simulated arm with effects hidden in them, for the diagnosis (or a student) to find.

    Recordings go to worlds/0000, worlds/0001, ...; truth.json alone says what is hidden. A tenth holds nothing.

    Example: armtwin seal --n 50 --seed 7 --out out/sealed
    """
    if uncatalogued is not None and not uncatalogued.is_file():
        raise InputError(f"--uncatalogued: no Python file '{uncatalogued}'")
    if moving and (frames or pairs or uncatalogued is not None):
        raise InputError(
            "--moving: its sets hold pairs, fours and unknown faults already, and angles instead of pictures; "
            "leave --frames, --pairs and --uncatalogued out"
        )
    check_out_folder(out)
    options = SealOptions(
        n=n,
        seed=seed,
        frames=frames,
        effects=_names(effects),
        pairs=pairs,
        uncatalogued=None if uncatalogued is None else str(uncatalogued.resolve()),
        moving=moving,
    )
    console = Console(stderr=True)
    with Progress(console=console, transient=True, disable=not console.is_terminal) as progress:
        bar = progress.add_task("sealing worlds", total=n)
        for _ in seal(out, options, jobs):
            progress.advance(bar)
    typer.echo(f"{n} worlds in {out / 'worlds'}, the truth in {out / 'truth.json'}; next: armtwin score {out}")


def _names(effects: str | None) -> tuple[str, ...]:
    """Names of the effects that are asked for; a person's own are registered and stand there by name."""
    asked = [name.strip() for name in effects.split(",")] if effects else []
    return tuple(register_file(Path(name)).name if name.endswith(".py") else name for name in asked)
